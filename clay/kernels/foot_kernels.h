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

/// A bit for each voxel of rows along z, those with side · phi > level: bits[x · kBitRows + y] for x < counts[0] and
/// y < counts[1], of counts[2] voxels (9 at most each). `phi` can be read kBrickEdge floats beyond each row.
inline constexpr int kBitRows = kBrickEdge + 1;
void bitsBeyond(const float* phi, ptrdiff_t strideX, ptrdiff_t strideY, const int (&counts)[3], float side, float level,
                uint32_t (&bits)[kBitRows * kBitRows]) noexcept;

/// Squared distances of `count` boxes from `p`, 0 inside. The arrays can be read, and `squares` written, kBrickEdge
/// floats beyond the last.
void boxSquares(const PointArrays& low, const PointArrays& high, size_t count, const float (&p)[3],
                float* squares) noexcept;

/// A surface of second order beside a point: z = −(κ₁ u² + κ₂ v²)/2 over its plane, z along the normal. 16 floats, so
/// that one lies in one line of the cache.
struct alignas(64) FootShape {
  float point[3], normal[3];
  float first[3];      ///< The direction of κ₁, unit length.
  float curvature[2];  ///< Per voxel.
  float beside2;       ///< Voxels²: how far the nearest place may be from the point. 0: no normal, the point counts.
};
/// A hollow's part that counts, of its radius: behind it something else is nearer.
inline constexpr float kDeepestHollow = 0.6f;
/// Of normals, beside what they are at the surface: the least that they spread by.
inline constexpr float kLeastSpread = 0.25f;
/// For each voxel of those rows of a block of 8³ from `low` on whose bit (x · 8 + y) is set, how far it is from the
/// surface beside shapes[nearest[voxel]].
void distancesToShapes(const FootShape* shapes, const uint32_t (&nearest)[kBrickVoxels], const float (&low)[3],
                       uint64_t rows, float (&distance)[kBrickVoxels]) noexcept;

/// Which of two distances counts beyond a level set, a voxel's own or the one that is measured from the level set.
struct FarField {
  float side, level;  ///< Beyond it is side · phi > level.
  float ownTo;        ///< Voxels beyond the level: so far its own has a part,
  float agree;        ///< if both differ by less.
  float reach;        ///< At most, from the surface.
};
/// The rows (x · 8 + y) of a block with a voxel beyond the level.
[[nodiscard]] uint64_t rowsBeyond(const float (&phi)[kBrickVoxels], const FarField& field) noexcept;
/// Voxels of `rows` that lie beyond the level get the distance that counts; `distance`: from the level set.
void takeFar(const float (&distance)[kBrickVoxels], uint64_t rows, const FarField& field,
             float (&phi)[kBrickVoxels]) noexcept;

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

/// For each voxel of 8³ from `low` on, z fastest, in those rows of eight whose bit (x · 8 + y) is set in `rows`, the
/// number of the nearest point of the ranges. `first`: the one that is nearest to the block's middle. Of several that
/// are equally near any one, the same on every CPU. `wide` and `narrow`: room. Cost: a look at every point of the
/// ranges, and eight for each of these rows at those that may be the nearest to some voxel.
void nearestPoints(const PointArrays& points, std::span<const PointRange> ranges, uint32_t first, const float (&low)[3],
                   uint64_t rows, PointRoom& wide, PointRoom& narrow, uint32_t (&nearest)[kBrickVoxels]);

}  // namespace argil::clay
