#include "clay/primitives.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "clay/editor.h"
#include "clay/error.h"

namespace argil::clay {

namespace {

constexpr int kMaxExtent = 65536;  // voxels along an axis: the plan's limit on a model

// Fills blocks top down: a block whose centre is farther from the surface than half its diagonal and the band is one
// tile. `distance` is a true distance in voxels (1-Lipschitz) at a voxel coordinate.
// What part of the whole a call is, for the person who waits.
struct Share {
  Job* job;
  double from, to;
  [[nodiscard]] Share child(int i) const { return {job, from + (to - from) * i / 512, from + (to - from) * (i + 1) / 512}; }
};

template <class Distance>
void fill(Editor& editor, const Distance& distance, Coord block, int level, const Share& share) {
  const int edge = 1 << (3 * level);  // bricks
  const double half = 0.5 * (edge * kBrickEdge - 1);
  const Vec3d first = (block * kBrickEdge).toVec3d();
  const double atCentre = distance(first + Vec3d::Constant(half));
  // Half a voxel more than needed keeps rounding out of the decision.
  if (std::abs(atCentre) > half * std::sqrt(3.0) + editor.grid().band + 0.5) {
    if (atCentre < 0) editor.setBlock(block, level, Tile::inside);
    return;
  }
  if (level > 0) {
    if (share.job) share.job->step(share.from);
    for (int i = 0; i < 512; ++i) fill(editor, distance, block + Coord{i >> 6, (i >> 3) & 7, i & 7} * (edge / 8), level - 1, share.child(i));
    return;
  }
  float phi[kBrickVoxels];
  for (int i = 0; i < kBrickVoxels; ++i)
    phi[i] = static_cast<float>(distance(first + Coord{i >> 6, (i >> 3) & 7, i & 7}.toVec3d()));
  editor.setVoxels(block, phi);
}

template <class Distance>
Version make(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm, const Vec3d& halfMm, const char* what,
             Job* job, const Distance& distance) {
  grid.check();
  const Vec3d half = halfMm / grid.voxelMm, centre = grid.toVoxel(centreMm);
  if (!centre.allFinite() || !half.allFinite() || half.minCoeff() < 1 || 2 * half.maxCoeff() > kMaxExtent)
    throw Error(fmt::format("{} of {} × {} × {} mm at voxels of {} mm: each side must be 2 to {} voxels", what, 2 * halfMm.x(), 2 * halfMm.y(),
                            2 * halfMm.z(), grid.voxelMm, kMaxExtent));
  if (centre.cwiseAbs().maxCoeff() > kMaxExtent)
    throw Error(fmt::format("{} lies more than {} voxels from its grid's origin: set the grid's origin near it", what, kMaxExtent));
  Editor editor(Version::empty(std::move(store), grid));
  fill(editor, distance, Editor::blockFirst({0, 0, 0}, kTreeLevels), kTreeLevels, {job, 0, 1});
  return editor.commit();
}

}  // namespace

Version makeSphere(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm, double radiusMm, Job* job) {
  const Vec3d centre = grid.toVoxel(centreMm);
  const double radius = radiusMm / grid.voxelMm;
  return make(std::move(store), grid, centreMm, Vec3d::Constant(radiusMm), "sphere", job,
              [&](const Vec3d& p) { return (p - centre).norm() - radius; });
}

Version makeBlock(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm, const Vec3d& sizeMm, double roundMm, Job* job) {
  if (!(roundMm >= 0 && 2 * roundMm <= sizeMm.minCoeff()))
    throw Error(fmt::format("block rounded by {} mm: give a radius from 0 to half its shortest side", roundMm));
  const Vec3d centre = grid.toVoxel(centreMm);
  const double round = roundMm / grid.voxelMm;
  const Vec3d core = sizeMm / (2 * grid.voxelMm) - Vec3d::Constant(round);
  return make(std::move(store), grid, centreMm, sizeMm / 2, "block", job, [&](const Vec3d& p) {
    const Vec3d q = (p - centre).cwiseAbs() - core;
    return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0) - round;
  });
}

}  // namespace argil::clay
