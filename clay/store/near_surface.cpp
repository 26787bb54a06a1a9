#include "clay/store/near_surface.h"

#include <algorithm>
#include <cmath>

#include "clay/store/brick_margins.h"

namespace argil::clay {
namespace {

// Voxels beside the surface lie within this of it. Slopes over two voxels that are less say nothing.
constexpr float kBesideSurface = 1, kLeastSlope = 0.2f;
// What is farther from the place than the nearest by no more than this counts.
constexpr float kAround = 2;
// From a brick's middle to its outermost voxels.
constexpr float kOutermost = 3.5f;
// Voxels that are looked at first; twice as many each time that there is nothing.
constexpr double kFirstReach = 8;

// A place, seen from the middle of a brick, so that mirrored bricks have mirrored bits.
Vec3f fromMiddle(const Vec3d& place, Coord brick) {
  return (place - ((brick * kBrickEdge).toVec3d() + Vec3d::Constant(3.5))).cast<float>();
}

std::vector<NearVoxel> within(Sampler& field, const Vec3d& place, double reach) {
  struct Near {
    float distance2;
    Coord brick;
  };
  std::vector<Near> bricks;
  const auto outside = [](float middle) { return std::max(std::abs(middle) - kOutermost, 0.0f); };
  const auto first = [](double v) { return static_cast<int32_t>(std::ceil((v - 7) / kBrickEdge)); };
  const auto last = [](double v) { return static_cast<int32_t>(std::floor(v / kBrickEdge)); };
  const double farthest = reach + static_cast<double>(kAround);
  const Vec3d low = place.array() - farthest, high = place.array() + farthest;
  for (int32_t bx = first(low.x()); bx <= last(high.x()); ++bx)
    for (int32_t by = first(low.y()); by <= last(high.y()); ++by)
      for (int32_t bz = first(low.z()); bz <= last(high.z()); ++bz) {
        if (field.slot({bx, by, bz}).isTile()) continue;
        const Vec3f middle = fromMiddle(place, {bx, by, bz});
        const float x = outside(middle.x()), y = outside(middle.y()), z = outside(middle.z());
        bricks.push_back({(x * x + y * y) + z * z, {bx, by, bz}});
      }
  std::sort(bricks.begin(), bricks.end(), [](const Near& a, const Near& b) { return a.distance2 < b.distance2; });
  std::vector<NearVoxel> found;
  auto nearest = static_cast<float>(reach);
  for (const Near& each : bricks) {
    if (each.distance2 > (nearest + kAround) * (nearest + kAround)) break;
    float padded[kPaddedSize] = {};
    gatherPadded(field, each.brick, padded);
    const Vec3f from = fromMiddle(place, each.brick);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const int x = i >> 6, y = (i >> 3) & 7, z = i & 7, at = paddedOffset(x + 1, y + 1, z + 1);
      if (!(std::abs(padded[at]) < kBesideSurface)) continue;
      const Vec3f way((static_cast<float>(x) - 3.5f) - from.x(), (static_cast<float>(y) - 3.5f) - from.y(),
                      (static_cast<float>(z) - 3.5f) - from.z());
      const float distance = std::sqrt((way.x() * way.x() + way.y() * way.y()) + way.z() * way.z());
      if (!(distance < nearest + kAround)) continue;
      nearest = std::min(nearest, distance);
      const Vec3f slope(padded[at + 10 * kPaddedRow] - padded[at - 10 * kPaddedRow],
                        padded[at + kPaddedRow] - padded[at - kPaddedRow], padded[at + 1] - padded[at - 1]);
      const float length = std::sqrt((slope.x() * slope.x() + slope.y() * slope.y()) + slope.z() * slope.z());
      if (length > kLeastSlope)
        found.push_back({distance, kBesideSurface - std::abs(padded[at]), slope / length, each.brick, i});
    }
  }
  for (NearVoxel& each : found) each.weight *= std::max(nearest + kAround - each.distance, 0.0f);
  return found;
}

}  // namespace

std::vector<NearVoxel> surfaceNear(Sampler& field, const Vec3d& place, double reach) {
  for (double far = kFirstReach;; far *= 2) {
    std::vector<NearVoxel> found = within(field, place, std::min(far, reach));
    const bool near = std::any_of(found.begin(), found.end(),
                                  [&](const NearVoxel& each) { return static_cast<double>(each.distance) <= far; });
    if (near || far >= reach) return found;
  }
}

}  // namespace argil::clay
