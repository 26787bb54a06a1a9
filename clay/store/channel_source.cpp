#include "clay/store/channel_source.h"

#include <algorithm>
#include <vector>

#include "clay/store/channel_mean.h"

namespace argil::clay {

namespace {

constexpr int kSteps = 64;  // places between voxels, for weights in whole numbers
constexpr int kFarthest = 2;

int squared(Coord c) {
  return c.x * c.x + c.y * c.y + c.z * c.z;
}

// Steps to the voxels around one, the nearest first.
const std::vector<Coord>& stepsAround() {
  static const std::vector<Coord> steps = [] {
    std::vector<Coord> all;
    for (int x = -kFarthest; x <= kFarthest; ++x)
      for (int y = -kFarthest; y <= kFarthest; ++y)
        for (int z = -kFarthest; z <= kFarthest; ++z) all.push_back({x, y, z});
    std::stable_sort(all.begin(), all.end(), [](Coord a, Coord b) { return squared(a) < squared(b); });
    return all;
  }();
  return steps;
}

}  // namespace

bool ChannelSource::any(const Version& version) {
  return std::any_of(kAllChannels.begin(), kAllChannels.end(), [&](Channel channel) { return version.has(channel); });
}

const ChannelPlace& ChannelSource::at(Coord brick) {
  if (!place_ || brick != last_) {
    last_ = brick;
    place_ = &reader_.at(brick);
  }
  return *place_;
}

bool ChannelSource::read(Coord voxel, ChannelBytes& bytes) {
  const ChannelPlace& place = at(voxel >> kBrickBits);
  const int offset = Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7);
  if (!place.inBand(offset, reader_.band())) return false;
  bytes = place.bytes(offset);
  return true;
}

int ChannelSource::nearest(Coord voxel, ChannelBytes& bytes) {
  for (const Coord step : stepsAround())
    if (read(voxel + step, bytes)) return squared(step);
  bytes = {};
  return kNone;
}

bool ChannelSource::between(const Vec3d& p, ChannelBytes& bytes) {
  int first[3], part[3];
  for (int i = 0; i < 3; ++i) {
    const auto steps = static_cast<int64_t>(std::floor(p[i] * kSteps + 0.5));
    first[i] = static_cast<int>(steps >= 0 ? steps / kSteps : -((-steps + kSteps - 1) / kSteps));
    part[i] = static_cast<int>(steps - int64_t{first[i]} * kSteps);
  }
  if (part[0] == 0 && part[1] == 0 && part[2] == 0) return read({first[0], first[1], first[2]}, bytes);
  ChannelMean mean;
  for (int corner = 0; corner < 8; ++corner) {
    const int step[3] = {corner >> 2, (corner >> 1) & 1, corner & 1};
    int64_t weight = 1;
    for (int i = 0; i < 3; ++i) weight *= step[i] ? part[i] : kSteps - part[i];
    ChannelBytes own;
    if (weight > 0 && read({first[0] + step[0], first[1] + step[1], first[2] + step[2]}, own)) mean.add(own, weight);
  }
  if (mean.empty()) return false;
  bytes = mean.value();
  return true;
}

void clearChannels(Editor& editor, Coord brick) {
  for (const Channel channel : kAllChannels)
    if (editor.has(channel)) editor.setChannelTile(channel, brick, false);
}

}  // namespace argil::clay
