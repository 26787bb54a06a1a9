#include "clay/cage/coarse_cage.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "clay/base/error.h"
#include "clay/field/region_work.h"
#include "clay/surface/surface.h"
#include "clay/whole/resample.h"

namespace argil::clay {

namespace {

constexpr size_t kLeastQuads = 24;
constexpr int kSizes = 8;   // of the coarse voxel, until the count fits
constexpr int kShifts = 8;  // of the grid, for the clay's shape

QuadMesh quadsOf(const Surface& surface) {
  // Two triangles a quad, along its corners 0 and 2.
  TriangleMesh mesh = surface.toMesh();
  QuadMesh quads;
  quads.positions = std::move(mesh.positions);
  for (size_t i = 0; i + 1 < mesh.triangles.size(); i += 2) {
    const auto &a = mesh.triangles[i], &b = mesh.triangles[i + 1];
    quads.quads.push_back({a[0], a[1], a[2], b[2]});
  }
  return quads;
}

int64_t shapeOf(const Surface& surface) {
  // Each quad has two edges of its own.
  return (static_cast<int64_t>(surface.vertexCount()) - static_cast<int64_t>(surface.quadCount())) / 2;
}

}  // namespace

CoarseCage coarseCage(const Version& version, size_t most, const WorkPart& part) {
  if (version.stats().bricks == 0) throw Error("the piece is empty: there is no surface to draw a cage on");
  if (most < kLeastQuads) throw Error(fmt::format("a cage of {} quads: give at least {}", most, kLeastQuads));
  const Grid& grid = version.grid();
  Surface own(false);
  own.update(version);
  CoarseCage best;
  best.clayShape = shapeOf(own);

  double voxel = std::max(grid.voxelMm, std::sqrt(areaOf(version) * 1.5 / double(most)) * grid.voxelMm);
  bool found = false;
  const auto tried = [&](double voxelMm, int shift) {
    Grid coarse = grid;
    coarse.voxelMm = voxelMm;
    const Vec3d move((shift & 1) / 2.0, (shift >> 1 & 1) / 2.0, (shift >> 2 & 1) / 2.0);
    coarse.originMm += voxelMm * (move + Vec3d::Constant(0.25));
    Surface surface(false);
    surface.update(voxelMm == grid.voxelMm ? version : resample(version, coarse, Eigen::Isometry3d::Identity(), 1));
    if (surface.quadCount() == 0 || surface.quadCount() > most) return surface.quadCount();
    const int64_t shape = shapeOf(surface);
    if (!found || std::abs(shape - best.clayShape) < std::abs(best.shape - best.clayShape)) {
      best.mesh = quadsOf(surface);
      best.edgeMm = voxelMm;
      best.shape = shape;
      found = true;
    }
    return surface.quadCount();
  };
  for (int i = 0; i < kSizes && !found; ++i) {
    const uint64_t count = tried(voxel, 0);
    if (!found) voxel *= count > most ? std::max(1.02, std::sqrt(double(count) / double(most))) : 0.7;
    part.step(0.5 * (i + 1) / kSizes);
  }
  if (!found)
    throw Error(fmt::format("no cage of at most {} quads goes around this piece: give more", most), Error::Kind::work);
  for (int shift = 1; shift < kShifts && best.shape != best.clayShape; ++shift) {
    if (tried(voxel, shift) > most) (void)tried(1.05 * voxel, shift);
    part.step(0.5 + 0.5 * shift / kShifts);
  }
  return best;
}

}  // namespace argil::clay
