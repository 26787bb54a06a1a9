#include "clay/field/neck_width.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <vector>

#include "clay/base/joined_sets.h"
#include "clay/store/sampler.h"

namespace argil::clay {

namespace {

constexpr int kFine = 4;  // places a voxel
constexpr int kHalf = NeckBox::kReach * kFine, kEdge = 2 * kHalf + 1;
constexpr double kVoxelOff = 0.87;  // from a place to the nearest voxel at most
constexpr float kPlane = 0.9f;      // voxels beside a place of the surface to where its plane stands for it

size_t numberOf(Coord fine) {  // from −kHalf to kHalf
  return static_cast<size_t>(((fine.x + kHalf) * kEdge + fine.y + kHalf) * kEdge + fine.z + kHalf);
}
int farthest(Coord fine) {
  return std::max({std::abs(fine.x), std::abs(fine.y), std::abs(fine.z)});
}

// Places of the surface and its normals there, from the middle on: where it crosses edges of voxels.
struct Places {
  std::vector<float> x, y, z;
  std::vector<Vec3f> normal;
};

Places placesAround(const Version& version, Coord middle, double radius) {
  // The nearest place to any point of the box is no farther from the middle than this.
  const double far = radius + 2 * NeckBox::kReach * std::sqrt(3.0) + 1;
  const int reach = static_cast<int>(std::ceil(far));
  Places places;
  Sampler sampler(version);
  for (int x = -reach; x <= reach; ++x)
    for (int y = -reach; y <= reach; ++y)
      for (int z = -reach; z <= reach; ++z) {
        const Coord low = middle + Coord{x, y, z};
        const float a = sampler.voxel(low);
        if (std::abs(a) >= version.grid().band) continue;
        for (const Coord step : {Coord{1, 0, 0}, Coord{0, 1, 0}, Coord{0, 0, 1}}) {
          const float b = sampler.voxel(low + step);
          if ((a < 0) == (b < 0)) continue;
          const Vec3d at = low.toVec3d() + step.toVec3d() * double(a / (a - b));
          Vec3f normal;
          sampler.trilinear(at, normal);
          const Vec3f off = (at - middle.toVec3d()).cast<float>();
          if (off.norm() > far || !(normal.norm() > 0.1f)) continue;
          places.x.push_back(off.x()), places.y.push_back(off.y()), places.z.push_back(off.z());
          places.normal.emplace_back(normal.normalized());
        }
      }
  return places;
}

float distanceTo(const Places& places, const Vec3f& p) {
  float best = std::numeric_limits<float>::infinity();
  size_t nearest = 0;
  for (size_t i = 0; i < places.x.size(); ++i) {
    const float dx = p.x() - places.x[i], dy = p.y() - places.y[i], dz = p.z() - places.z[i];
    const float squared = dx * dx + dy * dy + dz * dz;
    if (squared < best) best = squared, nearest = i;
  }
  if (places.x.empty()) return best;
  const Vec3f off = p - Vec3f(places.x[nearest], places.y[nearest], places.z[nearest]);
  const float height = off.dot(places.normal[nearest]);
  // Where the nearest place stands on an edge, its plane is that of neither face.
  const bool plane = best - height * height < kPlane * kPlane;
  const float distance = plane ? std::abs(height) : std::sqrt(best);
  return height < 0 ? -distance : distance;
}

// Calls back with each voxel of the box around a fine place, and how far it is, voxels.
template <class Visit>
void forEachVoxelAround(Coord fine, const Visit& visit) {
  const Coord low{(fine.x + kHalf) / kFine, (fine.y + kHalf) / kFine, (fine.z + kHalf) / kFine};
  for (int corner = 0; corner < 8; ++corner) {
    const Coord at = low + Coord{corner >> 2, (corner >> 1) & 1, corner & 1};
    if (std::max({at.x, at.y, at.z}) >= NeckBox::kEdge) continue;
    const Coord step = at - Coord{1, 1, 1} * NeckBox::kReach;
    visit(NeckBox::number(step), (step * kFine - fine).toVec3d().norm() / kFine);
  }
}

}  // namespace

NeckWidth neckWidth(const Version& version, const NeckBox& box) {
  const double radius = double(box.distance[NeckBox::number({0, 0, 0})]);
  const Places places = placesAround(version, box.middle, radius);
  std::vector<Coord> fine;
  for (int x = -kHalf; x <= kHalf; ++x)
    for (int y = -kHalf; y <= kHalf; ++y)
      for (int z = -kHalf; z <= kHalf; ++z) fine.push_back({x, y, z});
  std::vector<float> distance(fine.size());
  std::vector<NeckBox::End> end(fine.size(), NeckBox::End::none);
  for (size_t i = 0; i < fine.size(); ++i) {
    // No more than what voxels beside it allow: they know of lips that are thinner than what crosses their edges.
    float most = distanceTo(places, fine[i].toVec3d().cast<float>() / float(kFine));
    double nearest = kVoxelOff;
    forEachVoxelAround(fine[i], [&](size_t voxel, double far) {
      most = std::min(most, box.distance[voxel] + float(far));
      if (farthest(fine[i]) <= kHalf - kFine / 2 || box.end[voxel] == NeckBox::End::none || far >= nearest) return;
      nearest = far;
      end[i] = box.end[voxel];
    });
    distance[i] = most;
  }

  // The widest first: where both ends become one is the narrowest place.
  const auto count = static_cast<uint32_t>(fine.size());
  JoinedSets sets(count + 2);
  std::vector<uint32_t> order(fine.size());
  std::iota(order.begin(), order.end(), 0u);
  std::stable_sort(order.begin(), order.end(), [&](uint32_t a, uint32_t b) { return distance[a] > distance[b]; });
  std::vector<bool> is(fine.size());
  for (const uint32_t i : order) {
    is[i] = true;
    if (end[i] != NeckBox::End::none) sets.join(i, end[i] == NeckBox::End::one ? count : count + 1);
    for (int n = 0; n < 27; ++n) {
      const Coord next = fine[i] + Coord{n / 9 - 1, n / 3 % 3 - 1, n % 3 - 1};
      if (farthest(next) <= kHalf && is[numberOf(next)]) sets.join(i, static_cast<uint32_t>(numberOf(next)));
    }
    if (sets.find(count) == sets.find(count + 1))
      return {box.middle.toVec3d() + fine[i].toVec3d() / kFine, double(distance[i])};
  }
  return {box.middle.toVec3d(), radius};
}

}  // namespace argil::clay
