#pragma once
// Clay from a function that gives its distance.

#include <algorithm>
#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/base/memory_guard.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"

namespace argil::clay::solid {

inline constexpr int kMaxExtent = 65536;  // voxels along an axis: the plan's limit on a model
inline constexpr int kBlockBits = 3;      // A block of the tree has eight children along each edge.

/// What part of the whole a call is, for the person who waits.
struct Share {
  Job* job;
  double from, to;
  [[nodiscard]] Share child(int i) const { return {job, from + (to - from) * i / 8, from + (to - from) * (i + 1) / 8}; }
};

/// Fills cubes of 2^bits bricks an edge, top down: one whose centre is farther from the surface than half its diagonal
/// and the band is all inside or outside.
template <class Distance>
void fill(Editor& editor, const Distance& distance, Coord brick, int bits, const Share& share) {
  const double half = 0.5 * ((kBrickEdge << bits) - 1);
  const Vec3d first = (brick * kBrickEdge).toVec3d();
  const double atCentre = distance(first + Vec3d::Constant(half));
  // Half a voxel more than needed keeps rounding out of the decision.
  const bool far = std::abs(atCentre) > half * std::sqrt(3.0) + editor.grid().band + 0.5;
  if (far && atCentre >= 0) return;
  if (far && bits % kBlockBits == 0) {
    editor.setBlock(brick, bits / kBlockBits, Tile::inside);
    return;
  }
  if (bits > 0) {
    if (share.job && bits % kBlockBits == 0) share.job->step(share.from);
    for (int i = 0; i < 8; ++i)
      fill(editor, distance, brick + Coord{i >> 2, (i >> 1) & 1, i & 1} * (1 << (bits - 1)), bits - 1, share.child(i));
    return;
  }
  float phi[kBrickVoxels];
  for (int i = 0; i < kBrickVoxels; ++i)
    phi[i] = static_cast<float>(distance(first + Coord{i >> 6, (i >> 3) & 7, i & 7}.toVec3d()));
  editor.setVoxels(brick, phi);
}

/// The surface's area, voxels², by the cubes of 16 bricks an edge that lie within so much of it.
template <class Distance>
double areaOf(const Distance& distance, Coord brick, int bits) {
  constexpr int kBits = 4;
  const double half = 0.5 * ((kBrickEdge << bits) - 1), reach = half * std::sqrt(3.0);
  if (std::abs(distance((brick * kBrickEdge).toVec3d() + Vec3d::Constant(half))) > reach) return 0;
  if (bits == kBits) return std::pow(2 * half + 1, 3) / (2 * reach);
  double sum = 0;
  for (int i = 0; i < 8; ++i)
    sum += areaOf(distance, brick + Coord{i >> 2, (i >> 1) & 1, i & 1} * (1 << (bits - 1)), bits - 1);
  return sum;
}

/// `distance` is a true distance in voxels (1-Lipschitz) at a voxel coordinate. Throws Error for a box of less than two
/// voxels or more than 65 536 along an edge or from the origin to its middle, Cancelled.
template <class Distance>
Version make(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm, const Vec3d& halfMm,
             const char* what, Job* job, const Distance& distance) {
  grid.check();
  const Vec3d half = halfMm / grid.voxelMm, centre = grid.toVoxel(centreMm);
  if (!half.allFinite() || half.minCoeff() < 1 || 2 * half.maxCoeff() > kMaxExtent)
    throw Error(fmt::format("{} of {} × {} × {} mm at voxels of {} mm: each side must be 2 to {} voxels", what,
                            2 * halfMm.x(), 2 * halfMm.y(), 2 * halfMm.z(), grid.voxelMm, kMaxExtent));
  if (!(centre.array().abs() <= kMaxExtent).all())
    throw Error(fmt::format("{} lies more than {} voxels from its grid's origin: set the grid's origin near it", what,
                            kMaxExtent));
  requireMemory(bytesOfClay(areaOf(distance, Editor::blockFirst({0, 0, 0}, kTreeLevels), kBlockBits * kTreeLevels),
                            store->precision()),
                fmt::format("{} of {} × {} × {} mm at voxels of {} mm", what, 2 * halfMm.x(), 2 * halfMm.y(),
                            2 * halfMm.z(), grid.voxelMm),
                "use a larger voxel");
  Editor editor(Version::empty(std::move(store), grid));
  fill(editor, distance, Editor::blockFirst({0, 0, 0}, kTreeLevels), kBlockBits * kTreeLevels, {job, 0, 1});
  return editor.commit();
}

}  // namespace argil::clay::solid
