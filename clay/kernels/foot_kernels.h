#pragma once
// Which of many points is nearest to each voxel of a block.

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "clay/kernels/brick.h"

namespace argil::clay {

/// Coordinates in arrays of their own, which can be read kBrickEdge floats beyond the last point.
struct PointArrays {
  const float *x, *y, *z;
};
/// Numbers of points from `begin` to before `end`.
struct PointRange {
  uint32_t begin, end;
};

inline constexpr uint32_t kNoPoint = UINT32_MAX;

/// Points that may be the nearest to some voxel; used again from block to block. One thread each.
struct PointRoom {
  std::vector<float> x, y, z, row;
  std::vector<uint32_t> number;
  /// So that `count` points and a vector behind them fit.
  void fit(size_t count);
};

/// The squared distance from `p` to the nearest point of the range, if that is less than `best`, and its number in
/// `nearest`.
void nearestOf(const PointArrays& points, PointRange range, const float (&p)[3], float& best,
               uint32_t& nearest) noexcept;

/// For each voxel of 8³ from `low` on, z fastest, the number of the nearest point of the ranges. `first`: the one that
/// is nearest to the block's middle. Of several that are equally near any one, the same on every CPU. `wide` and
/// `narrow`: room. Cost: a look at every point of the ranges, and 512 at those that may be the nearest to some voxel.
void nearestPoints(const PointArrays& points, std::span<const PointRange> ranges, uint32_t first, const float (&low)[3],
                   PointRoom& wide, PointRoom& narrow, uint32_t (&nearest)[kBrickVoxels]);

}  // namespace argil::clay
