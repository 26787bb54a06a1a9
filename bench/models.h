#pragma once
// The sphere of the benchmarks: the same in the world, re-voxelized to a count of active voxels.

#include <string>
#include <vector>

#include "clay/store/version.h"

namespace argil::bench {

struct BenchModel {
  std::string name;  ///< Such as 48M.
  double radiusVoxels;
  clay::Version version;
};

/// A sphere of 40 mm about (3, 5, 7) mm with about `millions` of active voxels (a band of 3 on each side).
BenchModel benchSphere(double millions, clay::Precision precision = clay::Precision::float32);
/// A cube about (3, 5, 7) mm with about `millions` of active voxels; `radiusVoxels` is half its side. Its faces are
/// flat at every size, where the sphere is the more curved the coarser it is.
BenchModel benchCube(double millions);
/// 0.8, 3, 12, 48 and 200 million, up to `largest`.
std::vector<double> benchSizes(double largest);

}  // namespace argil::bench
