#include "clay/field/distance_box.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "clay/store/sampler.h"

namespace argil::clay {

namespace {

constexpr float kOwnTo = 1.0f;       // voxels beyond the level: so far the version's own values, the better ones there,
constexpr float kAgree = 0.15f;      // if they differ from what is measured by no more
constexpr float kLeastSlope = 0.5f;  // a gradient below that points nowhere

}  // namespace

bool DistanceBox::gather(const Version& version) {
  phi_.resize(voxelIndex(outer_, {outer_.x, 0, 0}) + kBrickEdge);  // vectors read on
  Sampler sampler(version);
  const float band = version.grid().band;
  const Coord end = outerLow_ + outer_;
  const Coord first = outerLow_ >> kBrickBits, last = (end - Coord{1, 1, 1}) >> kBrickBits;
  const Coord bricks = last - first + Coord{1, 1, 1};
  filled_.assign(voxelIndex(bricks, {bricks.x, 0, 0}), 0);
  bool surface = false;
  for (int bx = first.x; bx <= last.x; ++bx)
    for (int by = first.y; by <= last.y; ++by)
      for (int bz = first.z; bz <= last.z; ++bz) {
        const Slot slot = sampler.slot({bx, by, bz});
        const Brick* brick = slot.brick();
        surface |= brick != nullptr;
        filled_[voxelIndex(bricks, Coord{bx, by, bz} - first)] = brick != nullptr;
        const Coord from{std::max(bx * 8, outerLow_.x), std::max(by * 8, outerLow_.y), std::max(bz * 8, outerLow_.z)};
        const Coord to{std::min(bx * 8 + 8, end.x), std::min(by * 8 + 8, end.y), std::min(bz * 8 + 8, end.z)};
        if (!brick) uniform_ = slot.tile();
        const float constant = brick ? 0 : slot.phi(0, band);
        const bool whole = to.z - from.z == kBrickEdge;  // of a length that compilers know
        for (int x = from.x; x < to.x; ++x) {
          float* row = &phi_[index(Coord{x, from.y, from.z} - outerLow_)];
          for (int y = from.y; y < to.y; ++y, row += outer_.z) {
            const int offset = Brick::offset(x & 7, y & 7, from.z & 7);
            if (!brick && whole)
              std::fill_n(row, kBrickEdge, constant);
            else if (!brick)
              std::fill_n(row, to.z - from.z, constant);
            else if (whole)
              brick->read(offset, kBrickEdge, row);
            else
              brick->read(offset, to.z - from.z, row);
          }
        }
      }
  // A cell that the surface crosses has a corner in a brick; its first may lie in one of the blocks before.
  blocks_.clear();
  for (int x = 0; x < bricks.x; ++x)
    for (int y = 0; y < bricks.y; ++y)
      for (int z = 0; z < bricks.z; ++z) {
        bool any = false;
        for (int c = 0; c < 8 && !any; ++c) {
          const Coord at{std::min(x + (c >> 2), bricks.x - 1), std::min(y + ((c >> 1) & 1), bricks.y - 1),
                         std::min(z + (c & 1), bricks.z - 1)};
          any = filled_[voxelIndex(bricks, at)] != 0;
        }
        if (any) blocks_.push_back((first + Coord{x, y, z}) * kBrickEdge - outerLow_);
      }
  return surface;
}

void DistanceBox::measureBlock(FootPoints& points, Coord low, float side, float reach) {
  constexpr float kLevel = kOwnDistance;
  const FarField field{.side = side, .level = kLevel, .ownTo = kOwnTo, .agree = kAgree, .reach = reach};
  const Coord end = low_ + size_;
  const int count = std::min(kBrickEdge, end.z - low.z);
  // Rows of the block that lie in the box: each(first voxel, its number in the block).
  const auto forRows = [&](const auto& each) {
    for (int x = low.x; x < std::min(low.x + kBrickEdge, end.x); ++x)
      for (int y = low.y; y < std::min(low.y + kBrickEdge, end.y); ++y)
        each(Coord{x, y, low.z}, ((x - low.x) * kBrickEdge + y - low.y) * kBrickEdge);
  };
  float phi[kBrickVoxels] = {}, distance[kBrickVoxels];
  const auto copy = [&](const float* from, float* to) {
    if (count == kBrickEdge)
      std::copy_n(from, kBrickEdge, to);
    else
      std::copy_n(from, count, to);
  };
  forRows([&](Coord first, int v) { copy(&phi_[index(first)], phi + v); });
  const uint64_t rows = rowsBeyond(phi, field);
  if (rows == 0) return;
  const bool near = points.approach(low, reach - kLevel);
  if (near)
    points.measure(rows, distance);
  else
    std::fill(std::begin(distance), std::end(distance), 2 * reach);
  if (near && feet_)
    forRows([&](Coord first, int v) {
      for (int z = 0; z < count; ++z, ++v) {
        if (!(side * phi[v] > kLevel)) continue;
        // On from the level set to the surface itself, in the same direction.
        const Vec3f place = points.nearestPlace(v), way = place - (first + Coord{0, 0, z}).toVec3d().cast<float>();
        const float length = way.norm();
        const Vec3f foot = length > 0 ? Vec3f(place + way * (kLevel / length)) : place;
        foot_[index(first) + static_cast<size_t>(z)] = static_cast<int32_t>(index(voxelNear(foot)));
      }
    });
  takeFar(distance, rows, field, phi);
  forRows([&](Coord first, int v) { copy(phi + v, &phi_[index(first)]); });
}

void DistanceBox::measure(FootPoints& points, float side, float reach) {
  for (int x = 0; x < size_.x; x += kBrickEdge)
    for (int y = 0; y < size_.y; y += kBrickEdge)
      for (int z = 0; z < size_.z; z += kBrickEdge) measureBlock(points, low_ + Coord{x, y, z}, side, reach);
}

bool DistanceBox::fill(const Version& version, Coord low, Coord size, Reach reach) {
  const float band = version.grid().band, level = kOwnDistance;
  const float farthest = std::max(reach.inside, reach.outside);
  const int margin = farthest <= band ? 0 : static_cast<int>(std::ceil(farthest - level)) + 2;
  outerLow_ = low - Coord{margin, margin, margin};
  outer_ = size + Coord{2 * margin, 2 * margin, 2 * margin};
  low_ = low - outerLow_;
  size_ = size;
  feet_ = reach.feet;
  if (!gather(version)) return false;
  if (feet_) foot_.assign(phi_.size(), -1);
  // The points of both sides before either is measured: they are made of what the version has.
  const std::pair<float, float> sides[] = {{1, reach.outside}, {-1, reach.inside}};
  for (size_t i = 0; i < 2; ++i)
    if (sides[i].second > band) points_[i].make({phi_.data(), outer_, band, sides[i].first, level}, blocks_);
  for (size_t i = 0; i < 2; ++i)
    if (sides[i].second > band) measure(points_[i], sides[i].first, sides[i].second);
  if (reach.outside < band || reach.inside < band)
    for (float& phi : phi_) phi = std::clamp(phi, -reach.inside, reach.outside);
  return true;
}

Coord DistanceBox::voxelNear(const Vec3f& p) const {
  const auto near = [](float v, int size) { return std::clamp(static_cast<int>(std::floor(v + 0.5f)), 0, size - 1); };
  return {near(p.x(), outer_.x), near(p.y(), outer_.y), near(p.z(), outer_.z)};
}

Coord DistanceBox::foot(Coord voxel) const {
  const Coord v = voxel - outerLow_;
  if (const int32_t known = foot_[index(v)]; known >= 0) {
    const int z = known % outer_.z, rest = known / outer_.z;
    return outerLow_ + Coord{rest / outer_.y, rest % outer_.y, z};
  }
  Vec3f gradient;
  const int place[3] = {v.x, v.y, v.z}, size[3] = {outer_.x, outer_.y, outer_.z};
  for (int axis = 0; axis < 3; ++axis) {
    Coord before = v, after = v;
    int32_t* const ends[2] = {axis == 0   ? &before.x
                              : axis == 1 ? &before.y
                                          : &before.z,
                              axis == 0   ? &after.x
                              : axis == 1 ? &after.y
                                          : &after.z};
    *ends[0] = std::max(place[axis] - 1, 0);
    *ends[1] = std::min(place[axis] + 1, size[axis] - 1);
    const int apart = *ends[1] - *ends[0];
    gradient[axis] = apart > 0 ? (phi_[index(after)] - phi_[index(before)]) / static_cast<float>(apart) : 0;
  }
  const float length = gradient.norm();
  if (!(length > kLeastSlope)) return voxel;
  return outerLow_ + voxelNear(v.toVec3d().cast<float>() - gradient * (phi_[index(v)] / length));
}

}  // namespace argil::clay
