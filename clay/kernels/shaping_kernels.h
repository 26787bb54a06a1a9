#pragma once
// Arithmetic of raising and levelling on one brick, and of renewing distances; compiled once per SIMD target.

#include <cstdint>
#include <span>

#include "clay/kernels/brush_kernels.h"

namespace argil::clay {

/// A distance that is not known yet.
inline constexpr float kUnknownDistance = 1e6f;

/// A brick with two voxels of its neighbours around it: [x][y][z] at (x·12 + y)·12 + z, voxel (0,0,0) of the brick at
/// index 2, 2, 2.
inline constexpr int kWideRow = 12;
inline constexpr int kWideSize = 12 * 12 * kWideRow + 16;
inline constexpr int wideOffset(int x, int y, int z) {
  return (x * 12 + y) * kWideRow + z;
}

/// One Jacobi pass of |∇u| = 1, upwind and of second order where two voxels of an axis are known. Voxels whose bit in
/// `frozen` is set keep their value, values beyond `cap` become kUnknownDistance. Computes those rows of eight voxels
/// along z whose bit (x·8 + y) is set in `rows` and writes them to `out`, a brick's 512 values; the rows that differ.
uint64_t widePass(const float* wide, const uint64_t* frozen, uint64_t rows, float cap, float* out) noexcept;

/// From each voxel of `rows` (as widePass) to its nearest point of u = 0: −u·∇u/|∇u|, three times 512 values. 0 where u
/// is not known. `box`: the least and the largest x, y, z of where the feet of known voxels lie, from the brick's
/// middle.
void wideFeet(const float* wide, uint64_t rows, float* foot, float (&box)[2][3]) noexcept;

/// As ballWeights, taken at the feet of the voxels instead of at the voxels. The constant falloff's rim is two voxels
/// wide: a step within one voxel could not be told from a step elsewhere in it.
void footWeights(const SweptBall& ball, int shape, float strength, const float* foot, float* weight) noexcept;

/// height = min(height + gain · weight, limit) where a bit of `mask` is set and the weight is not zero; no height is
/// above the limit. Whether any changed.
bool raiseHeights(const float* weight, float gain, float limit, const uint64_t* mask, float* height) noexcept;

/// side · (u − h)/√(1 + |∇h|²), h the height, where that is not zero and u is known; elsewhere `phi` keeps its value.
/// `padded`: the heights with one voxel around them.
void raisedDistances(const float* u, const float* padded, float side, float* phi) noexcept;

/// What of the surface each voxel of a brick stands for: its share of the area (a cubic B-spline of its distance, times
/// `weight`; 0 for none), the surface's normal there, and the place of it that is nearest, from `origin`, which is
/// given from the brick's middle.
struct SurfaceParts {
  float weight[kBrickVoxels], normal[3][kBrickVoxels], place[3][kBrickVoxels];
};
/// `padded`: the field with one voxel around the brick.
void surfaceParts(const float* padded, const float* weight, const float (&origin)[3], SurfaceParts& parts) noexcept;

/// One of them: 1, the normal, the place from the stamp's middle, and its weight.
struct alignas(32) SurfacePart {
  float one = 1, normal[3] = {}, place[3] = {}, weight = 0;
};
/// Adds weight · (1, normal, place, ·) to `sums`, each rounded to a multiple of 2⁻¹⁸, and so exact up to 2³⁴: the order
/// does not matter. With `facing`, a direction, each weighs by the fourth power of the cosine between it and the normal
/// as well; not at all where they look away from each other.
void sumParts(std::span<const SurfacePart> parts, const float* facing, double (&sums)[8]) noexcept;

/// A brick with four voxels of its neighbours around it: [x][y][z] at (x·16 + y)·16 + z, voxel (0,0,0) of the brick at
/// index 4, 4, 4.
inline constexpr int kBroadRow = 16;
inline constexpr int kBroadSize = 16 * 16 * kBroadRow + 16;
inline constexpr int broadOffset(int x, int y, int z) {
  return (x * 16 + y) * kBroadRow + z;
}

struct WeighedBall {
  SweptBall ball;
  float strength;
};
/// φ − gain · weight, the largest of the balls' weights (falloff · strength, as footWeights) at each voxel's nearest
/// point of the surface, where |φ| < `band`, and beside that on the side that the surface moves to (above zero where
/// `gain` is); elsewhere φ. `broad` needs two voxels around the brick.
void raiseAtFeet(const float* broad, float band, std::span<const WeighedBall> balls, int shape, float gain,
                 float* phi) noexcept;

/// Towards a plane, from the middle of a brick: normal · p − offset above it.
struct LevelPlane {
  float nx, ny, nz, offset;
  bool down, up;   ///< What stands above it may go down, what lies below may come up.
  float share;     ///< Of the way to it, times a voxel's weight.
  float most;      ///< Voxels that anything moves.
  float done = 0;  ///< Voxels of the way that parts of the stamp before this one have cared for.
};
/// Each voxel's height above the plane, and how far its clay rises along the normal (below zero: sinks): a share of the
/// way to the surface there as far as that faces the way of the plane. A bit of `moves` where that is not zero, of
/// weighed voxels in the band. `broad` needs one voxel around the brick.
void levelRises(const float* broad, float band, const float* weight, const LevelPlane& plane, float* height,
                float* rise, uint64_t (&moves)[kBrickEdge]) noexcept;

/// Where redistancing by widePass begins, from a brick and at least two voxels around it: the field around the brick as
/// far as it is known (|φ| < `band`), inside it `near` (by paddedOffset) at frozen voxels, with the field's sign; what
/// is not known is ±kUnknownDistance.
void startWide(const float* broad, const float* near, const uint64_t* frozen, float band, float* wide) noexcept;

/// Whether two voxels that share a face, one of them in the brick, differ by more than `most`; by paddedOffset.
[[nodiscard]] bool isSteep(const float* padded, float most) noexcept;
/// Whether the slopes between voxels of a brick, where it is nearer to the surface than `within`, are 1 to `tolerance`.
[[nodiscard]] bool isSlopeOne(const float* values, float within, float tolerance) noexcept;

}  // namespace argil::clay
