#include "clay/brush/mask_reach.h"

#include <algorithm>
#include <cmath>

namespace argil::clay {
namespace {

constexpr float kNear = 0.5f;  // of the surface: some voxel of every place of it is
// voxels: places that are farther than the nearest by less count too, as a rim would be jagged without
constexpr double kBlend = 1;
constexpr int kWhole = 1 << 12;

// Voxels between two bricks at least and at most, squared.
int64_t leastBetween(Coord a, Coord b) {
  int64_t sum = 0;
  for (const int d : {a.x - b.x, a.y - b.y, a.z - b.z}) {
    const int64_t gap = std::max(std::abs(d) * kBrickEdge - (kBrickEdge - 1), 0);
    sum += gap * gap;
  }
  return sum;
}

int64_t mostBetween(Coord a, Coord b) {
  int64_t sum = 0;
  for (const int d : {a.x - b.x, a.y - b.y, a.z - b.z}) {
    const int64_t span = std::abs(d) * kBrickEdge + (kBrickEdge - 1);
    sum += span * span;
  }
  return sum;
}

}  // namespace

const std::vector<MaskReach::BrickPlaces>& MaskReach::region(Coord region) {
  const auto [entry, fresh] = regions_.try_emplace(region);
  if (!fresh) return entry->second;
  for (int i = 0; i < 512; ++i) {
    const Coord coord = region * 8 + Coord{i >> 6, (i >> 3) & 7, i & 7};
    const Slot slot = start_.find(coord);
    if (slot.isTile()) continue;
    const ChannelSlot mask = start_.find(Channel::mask, coord);
    BrickPlaces found;
    found.brick = coord;
    for (int v = 0; v < kBrickVoxels; ++v) {
      if (!(std::abs(slot.brick()->phi(v)) <= kNear)) continue;
      const int cover = mask.value(v);
      found.least = std::min(found.least, cover);
      found.most = std::max(found.most, cover);
      found.places.push_back({coord * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7}, cover});
    }
    if (!found.places.empty()) entry->second.push_back(std::move(found));
  }
  return entry->second;
}

const MaskCover& MaskReach::at(Coord brick, double reach) {
  Known& known = known_[brick];
  if (known.reach >= reach) return known.cover;
  known.reach = reach;
  MaskCover& cover = known.cover = {};
  const auto limit = static_cast<int64_t>(reach * reach);
  const int rings = static_cast<int>(std::ceil(reach / kBrickEdge)) + 1;
  std::vector<const BrickPlaces*> around;
  int64_t nearest = limit;
  const Coord low = (brick - Coord{rings, rings, rings}) >> 3, high = (brick + Coord{rings, rings, rings}) >> 3;
  for (int x = low.x; x <= high.x; ++x)
    for (int y = low.y; y <= high.y; ++y)
      for (int z = low.z; z <= high.z; ++z)
        for (const BrickPlaces& each : region({x, y, z})) {
          if (leastBetween(each.brick, brick) > limit) continue;
          around.push_back(&each);
          nearest = std::min(nearest, mostBetween(each.brick, brick));
        }
  const double farthest = std::sqrt(static_cast<double>(nearest)) + kBlend;
  std::erase_if(around, [&](const BrickPlaces* each) {
    return static_cast<double>(leastBetween(each->brick, brick)) > farthest * farthest;
  });
  if (std::all_of(around.begin(), around.end(), [](const BrickPlaces* each) { return each->most == 0; })) return cover;
  cover.none = false;
  if (nearest < limit &&
      std::all_of(around.begin(), around.end(), [](const BrickPlaces* each) { return each->least == 255; })) {
    cover.whole = true;
    cover.value.fill(255);
    return cover;
  }
  std::vector<int> squares;
  for (int v = 0; v < kBrickVoxels; ++v) {
    const Coord at = brick * kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
    squares.clear();
    int least = INT32_MAX;
    for (const BrickPlaces* each : around)
      for (const Place& place : each->places) {
        const Coord d = place.voxel - at;
        squares.push_back(d.x * d.x + d.y * d.y + d.z * d.z);
        least = std::min(least, squares.back());
      }
    if (least > limit) continue;
    const double root = std::sqrt(static_cast<double>(least)), most = (root + kBlend) * (root + kBlend);
    int64_t sum = 0, weights = 0;
    size_t next = 0;
    for (const BrickPlaces* each : around)
      for (const Place& place : each->places) {
        const int square = squares[next++];
        if (square > most) continue;
        const auto weight =
            static_cast<int64_t>(kWhole * (1 - (std::sqrt(static_cast<double>(square)) - root) / kBlend));
        sum += weight * place.cover;
        weights += weight;
      }
    cover.value[static_cast<size_t>(v)] = static_cast<uint8_t>((sum + weights / 2) / weights);
  }
  cover.none = std::all_of(cover.value.begin(), cover.value.end(), [](uint8_t c) { return c == 0; });
  cover.whole = std::all_of(cover.value.begin(), cover.value.end(), [](uint8_t c) { return c == 255; });
  return cover;
}

}  // namespace argil::clay
