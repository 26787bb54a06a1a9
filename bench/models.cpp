#include "bench/models.h"

#include <cmath>

#include <fmt/format.h>

#include "clay/field/primitives.h"
#include "clay/store/store.h"

namespace argil::bench {

BenchModel benchSphere(double millions, clay::Precision precision) {
  constexpr double kRadiusMm = 40;
  BenchModel model;
  model.name = fmt::format("{:g}M", millions);
  // Active voxels: 4πr² · 6.
  model.radiusVoxels = std::sqrt(millions * 1e6 / (24 * M_PI));
  clay::Grid grid;
  grid.voxelMm = kRadiusMm / model.radiusVoxels;
  model.version = clay::makeSphere(clay::Store::make(precision), grid, Vec3d(3, 5, 7), kRadiusMm);
  return model;
}

BenchModel benchCube(double millions) {
  constexpr double kSideMm = 80;
  BenchModel model;
  model.name = fmt::format("{:g}M", millions);
  // Active voxels: 6a² · 6.
  const double side = std::sqrt(millions * 1e6 / 36);
  model.radiusVoxels = side / 2;
  clay::Grid grid;
  grid.voxelMm = kSideMm / side;
  model.version = clay::makeBlock(clay::Store::make(), grid, Vec3d(3, 5, 7), Vec3d::Constant(kSideMm), 0);
  return model;
}

std::vector<double> benchSizes(double largest) {
  std::vector<double> sizes;
  for (const double size : {0.8, 3.0, 12.0, 48.0, 200.0})
    if (size <= largest) sizes.push_back(size);
  return sizes;
}

}  // namespace argil::bench
