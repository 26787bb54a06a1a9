#include "engine/print/base.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "clay/base/error.h"
#include "clay/base/work_part.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"
#include "clay/whole/resample.h"

namespace argil::engine {

namespace {

constexpr double kLeastHeight = 4;  // voxels
constexpr double kRim = 0.1;        // of the height: how far its edges are rounded
constexpr double kDot = 0.3;        // of the height: a dot's depth
constexpr double kLeastDot = 2;     // voxels, of a dot's radius
constexpr double kDotsApart = 3;    // radii
constexpr int kDotsInARow = 3;
constexpr int kThreads = 2;

}  // namespace

clay::Version withBase(const clay::Version& version, const haptics::Pose& pose, const BaseOptions& options, Job* job,
                       clay::ThinParts* gone) {
  const clay::WorkPart part(job);
  const clay::Grid& grid = version.grid();
  const double voxel = grid.voxelMm;
  if (!(options.heightMm >= kLeastHeight * voxel && options.heightMm <= 1000))
    throw Error(fmt::format("a base of {:g} mm at voxels of {:g} mm: give {:g} to 1000 mm", options.heightMm, voxel,
                            kLeastHeight * voxel));
  if (!(options.marginMm >= 0 && options.marginMm <= 1000))
    throw Error(fmt::format("a margin of {:g} mm: give 0 to 1000 mm", options.marginMm));
  if (!(options.sunkMm >= 0 && options.sunkMm < options.heightMm))
    throw Error(fmt::format("sunk by {:g} mm into a base of {:g} mm: give 0 to less than its height", options.sunkMm,
                            options.heightMm));
  if (options.dots < 0 || options.dots > 9) throw Error(fmt::format("{} dots: give 0 to 9", options.dots));

  Eigen::AlignedBox3d box;
  std::vector<Vec3d> places;
  {
    clay::Surface surface(false, clay::Grade::crisp);
    (void)surface.update(version, kThreads);
    if (surface.quadCount() == 0) throw Error("it has no clay");
    surface.forEach([&](const clay::BrickMesh& mesh) {
      for (const Vec3f& each : mesh.positions) {
        places.push_back(pose.apply(grid.toWorld(mesh.brick.toVec3d() * clay::kBrickEdge + each.cast<double>())));
        box.extend(places.back());
      }
    });
  }
  part.step(0.2);
  const double top = box.min().z() + options.sunkMm, round = std::max(kRim * options.heightMm, 0.0);
  Vec3d centre = box.center();
  centre.z() = top - options.heightMm / 2;
  // Upright in the world, with its middle at zero; then taken to where the piece is.
  clay::Grid own = grid;
  own.originMm = Vec3d::Zero();
  const auto store = [&] { return clay::Store::make(version.store()->precision()); };
  clay::Version base;
  double half;
  if (options.square) {
    const Vec3d size(box.sizes().x() + 2 * options.marginMm, box.sizes().y() + 2 * options.marginMm, options.heightMm);
    base = clay::makeBlock(store(), own, Vec3d::Zero(), size, round, job);
    half = std::min(size.x(), size.y()) / 2;
  } else {
    double radius = 0;
    for (const Vec3d& each : places)
      radius = std::max(radius, std::hypot(each.x() - centre.x(), each.y() - centre.y()));
    half = radius + options.marginMm;
    base = clay::makeCylinder(store(), own, Vec3d::Zero(), half, options.heightMm, round, job);
  }
  part.step(0.4);
  if (options.dots > 0) {
    const double radius = kDot * options.heightMm, apart = kDotsApart * radius;
    const int rows = (options.dots + kDotsInARow - 1) / kDotsInARow;
    const double reach = std::hypot((std::min(options.dots, kDotsInARow) - 1) * apart / 2, (rows - 1) * apart / 2);
    if (radius < kLeastDot * voxel || reach + 1.5 * radius > half)
      throw Error(fmt::format("{} dots have no room in a base of {:.3g} mm that is {:.3g} mm high: give a larger one",
                              options.dots, 2 * half, options.heightMm));
    for (int i = 0; i < options.dots; ++i) {
      const int row = i / kDotsInARow, in = std::min(options.dots - row * kDotsInARow, kDotsInARow);
      const Vec3d at((i % kDotsInARow - (in - 1) / 2.0) * apart, (row - (rows - 1) / 2.0) * apart,
                     -options.heightMm / 2);
      base = clay::combine(base, clay::makeSphere(store(), own, at, radius), clay::Combination::cut);
    }
  }
  part.step(0.5);
  Eigen::Isometry3d there = Eigen::Isometry3d::Identity();
  there.linear() = pose.rotation.conjugate().toRotationMatrix();
  there.translation() = pose.applyInverse(centre);
  base = clay::resample(base, grid, there, 0, part.part(0.5, 0.8));
  return clay::combine(version, base, clay::Combination::join, {.gone = gone}, part.part(0.8, 1));
}

}  // namespace argil::engine
