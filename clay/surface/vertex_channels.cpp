#include "clay/surface/vertex_channels.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "clay/store/channel_mean.h"

namespace argil::clay {

namespace {

constexpr int kSteps = 64;  // places between voxels, for weights in whole numbers

// The voxels around the vertices of a brick lie in it and in those one step higher.
std::vector<VertexPaint> paintOf(ChannelReader<Version>& clay, const BrickMesh& mesh) {
  const ChannelPlace* places[8];
  bool any = false;
  for (int i = 0; i < 8; ++i) {
    places[i] = &clay.at(mesh.brick + Coord{i >> 2, (i >> 1) & 1, i & 1});
    any = any || !places[i]->empty();
  }
  if (!any) return {};
  std::vector<VertexPaint> paint;
  paint.reserve(mesh.positions.size());
  any = false;
  for (const Vec3f& p : mesh.positions) {
    int cell[3], part[3];
    for (int i = 0; i < 3; ++i) {
      const int steps = std::clamp(static_cast<int>(p[i] * kSteps + 0.5f), 0, kBrickEdge * kSteps);
      cell[i] = std::min(steps / kSteps, kBrickEdge - 1);
      part[i] = steps - cell[i] * kSteps;
    }
    // Where all around is alike, as nearly everywhere, that is the mean.
    ChannelBytes corners[8];
    int64_t weights[8];
    int count = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const int step[3] = {corner >> 2, (corner >> 1) & 1, corner & 1};
      int64_t weight = 1;
      int voxel[3], brick = 0;
      for (int i = 0; i < 3; ++i) {
        weight *= step[i] ? part[i] : kSteps - part[i];
        voxel[i] = cell[i] + step[i];
        brick = brick * 2 + (voxel[i] == kBrickEdge);
      }
      const int offset = Brick::offset(voxel[0] & 7, voxel[1] & 7, voxel[2] & 7);
      if (weight == 0 || !places[brick]->inBand(offset, clay.band())) continue;
      weights[count] = weight;
      corners[count++] = places[brick]->bytes(offset);
    }
    ChannelBytes bytes = count > 0 ? corners[0] : ChannelBytes{};
    if (!std::all_of(corners, corners + count, [&](const ChannelBytes& each) { return each == bytes; })) {
      ChannelMean mean;
      for (int i = 0; i < count; ++i) mean.add(corners[i], weights[i]);
      bytes = mean.value();
    } else if (bytes[indexOf(Channel::cover)] == 0) {
      bytes[0] = bytes[1] = bytes[2] = 0;  // a colour that covers nothing is none
    }
    paint.push_back({bytes[0], bytes[1], bytes[2], bytes[indexOf(Channel::cover)], bytes[indexOf(Channel::material)],
                     bytes[indexOf(Channel::mask)]});
    any = any || paint.back() != VertexPaint{};
  }
  if (!any) paint.clear();
  return paint;
}

}  // namespace

bool hasChannels(const Version& version) {
  return std::any_of(kAllChannels.begin(), kAllChannels.end(), [&](Channel channel) { return version.has(channel); });
}

std::vector<VertexPaint> brickPaint(const Version& version, const BrickMesh& mesh) {
  if (!hasChannels(version)) return {};
  ChannelReader<Version> clay(version);
  return paintOf(clay, mesh);
}

void SurfacePaint::follow(const Version& version, const Surface& surface, SurfaceDelta& delta) {
  const Version before = std::exchange(version_, version);
  const bool same = before && before.store() == version.store() && before.grid() == version.grid();
  if (!hasChannels(version) && painted_.empty()) return;
  BrickSet look;
  // A changed brick is seen by vertices of its own and of those one step lower.
  const auto addSeen = [&](Coord brick) {
    for (int i = 0; i < 8; ++i) look.add(brick - Coord{i >> 2, (i >> 1) & 1, i & 1});
  };
  const Version from = same ? before : Version::empty(version.store(), version.grid());
  for (const Channel channel : kAllChannels)
    Version::forEachDifference(channel, from, version, [&](Coord brick, ChannelSlot, ChannelSlot) { addSeen(brick); });
  if (!same)
    for (const Coord brick : painted_) look.add(brick);
  ChannelReader<Version> clay(version);
  if (same) {
    for (const BrickMeshPtr& mesh : delta.changed) look.add(mesh->brick);
  }
  for (const Coord brick : look.sorted()) {
    const BrickMesh* mesh = surface.find(brick);
    auto paint = std::make_shared<BrickPaint>();
    paint->brick = brick;
    if (mesh) paint->vertices = paintOf(clay, *mesh);
    const bool had = painted_.erase(brick) > 0;
    if (!paint->vertices.empty()) painted_.insert(brick);
    if (mesh && (had || !paint->vertices.empty())) delta.painted.push_back(std::move(paint));
  }
}

std::vector<VertexPaint> meshPaint(const Surface& surface) {
  const Version& version = surface.version();
  if (!version || !hasChannels(version)) return {};
  ChannelReader<Version> clay(version);
  std::vector<VertexPaint> all;
  all.reserve(surface.vertexCount());
  surface.forEach([&](const BrickMesh& mesh) {
    const std::vector<VertexPaint> paint = paintOf(clay, mesh);
    all.insert(all.end(), paint.begin(), paint.end());
    if (paint.empty()) all.resize(all.size() + mesh.positions.size());
  });
  return all;
}

}  // namespace argil::clay
