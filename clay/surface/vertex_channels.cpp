#include "clay/surface/vertex_channels.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "clay/store/channel_mean.h"

namespace argil::clay {

namespace {

constexpr int kSteps = 64;  // places between voxels, for weights in whole numbers

bool hasChannels(const Version& version) {
  return std::any_of(kAllChannels.begin(), kAllChannels.end(), [&](Channel channel) { return version.has(channel); });
}

// A voxel's bytes in all channels (channelBytes), and whether it is in the band; 0 where it is not.
using PackedBytes = uint64_t;
constexpr int kInBandByte = kChannels;
static_assert(kInBandByte < 8);

// Bytes 0 or 1 by the lowest eight bits.
constexpr uint64_t bytesOfBits(uint64_t bits) {
  constexpr uint64_t kOnes = 0x0101010101010101, kEach = 0x8040201008040201, kLow = 0x7f7f7f7f7f7f7f7f;
  const uint64_t apart = ((bits & 0xff) * kOnes) & kEach;
  return ((((apart & kLow) + kLow) | apart) >> 7) & kOnes;
}
// Byte i of word k becomes byte k of word i.
void transpose(uint64_t (&words)[8]) {
  constexpr uint64_t kLow[] = {0x00ff00ff00ff00ff, 0x0000ffff0000ffff, 0x00000000ffffffff};
  for (int k = 2; k >= 0; --k)
    for (int step = 1 << k, i = 0; i < 8; ++i) {
      if (i & step) continue;
      const uint64_t other = ((words[i] >> (8 * step)) ^ words[i + step]) & kLow[k];
      words[i + step] ^= other;
      words[i] ^= other << (8 * step);
    }
}

// The voxels around the vertices of a brick lie in it and in those one step higher.
constexpr int kSeen = kBrickEdge + 1;
struct SeenVoxels {
  PackedBytes at[kSeen][kSeen][kSeen];

  SeenVoxels(const ChannelPlace* const (&places)[8], float band) {
    for (int i = 0; i < 8; ++i) take(*places[i], {i >> 2, (i >> 1) & 1, i & 1}, band);
  }

 private:
  void take(const ChannelPlace& place, Coord step, float band) {
    uint64_t bits[kBrickEdge] = {};
    if (place.distance.brick()) place.inBand(band, bits);
    for (int x = 0; x < (step.x ? 1 : kBrickEdge); ++x)
      for (int y = 0; y < (step.y ? 1 : kBrickEdge); ++y) {
        const uint64_t inBand = bytesOfBits(bits[x] >> (y * kBrickEdge));
        uint64_t words[8] = {};
        for (size_t i = 0; i < kChannels; ++i) {
          const ChannelBrick* brick = place.channel[i].brick();
          if (brick) std::memcpy(&words[i], brick->value + Brick::offset(x, y, 0), sizeof words[i]);
          if (!brick && place.channel[i] != ChannelSlot()) words[i] = ~uint64_t{0};
          words[i] &= inBand * 0xff;
        }
        words[kInBandByte] = inBand;
        transpose(words);
        std::copy_n(words, step.z ? 1 : kBrickEdge,
                    &at[step.x * kBrickEdge + x][step.y * kBrickEdge + y][step.z * kBrickEdge]);
      }
  }
};

std::vector<VertexPaint> paintOf(ChannelReader<Version>& clay, const BrickMesh& mesh) {
  const ChannelPlace* places[8];
  bool any = false;
  for (int i = 0; i < 8; ++i) {
    places[i] = &clay.at(mesh.brick + Coord{i >> 2, (i >> 1) & 1, i & 1});
    any = any || !places[i]->empty();
  }
  if (!any) return {};
  const SeenVoxels seen(places, clay.band());
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
    PackedBytes corners[8];
    int64_t weights[8];
    int count = 0;
    for (int corner = 0; corner < 8; ++corner) {
      const int step[3] = {corner >> 2, (corner >> 1) & 1, corner & 1};
      int64_t weight = 1;
      for (int i = 0; i < 3; ++i) weight *= step[i] ? part[i] : kSteps - part[i];
      const PackedBytes bytes = seen.at[cell[0] + step[0]][cell[1] + step[1]][cell[2] + step[2]];
      if (weight == 0 || bytes == 0) continue;
      weights[count] = weight;
      corners[count++] = bytes;
    }
    ChannelBytes bytes = count > 0 ? channelBytes(corners[0]) : ChannelBytes{};
    if (!std::all_of(corners, corners + count, [&](PackedBytes each) { return each == corners[0]; })) {
      ChannelMean mean;
      for (int i = 0; i < count; ++i) mean.add(channelBytes(corners[i]), weights[i]);
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
