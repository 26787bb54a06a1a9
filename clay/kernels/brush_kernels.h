#pragma once
// Arithmetic of brushes on one brick; the file that is compiled once per SIMD target.

#include <cstdint>

#include "clay/kernels/brick.h"

namespace argil::clay {

/// A ball swept along a segment, relative to the middle (3.5, 3.5, 3.5) of the brick it is applied to, so that mirrored
/// places have mirrored bits; voxels.
struct SweptBall {
  float ax, ay, az;      ///< Start.
  float dx, dy, dz;      ///< End − start.
  float inverseLength2;  ///< 1 / |d|², 0 for a single dab.
  float radius;          ///< At the start.
  float growth;          ///< End − start.
};

struct BrickChange {
  bool changed = false;  ///< Some bit of phi differs from the source.
  bool inBand = false;   ///< Some |phi| < band.
};

/// A brick with one voxel of its neighbours around it: [x][y][z] at (x·10 + y)·kPaddedRow + z, voxel (0,0,0) of the
/// brick at index 1, 1, 1. Rows are longer than the ten values used so that vector loads stay inside.
inline constexpr int kPaddedRow = 12;
inline constexpr int kPaddedSize = 10 * 10 * kPaddedRow + 16;
inline constexpr int paddedOffset(int x, int y, int z) {
  return (x * 10 + y) * kPaddedRow + z;
}

// All of these use add, multiply, divide, square root, min and max only, in one order: equal bits on every target and
// to the scalar reference. They write out.value and out.inside. `out.value` may be `phi`.

/// max(phi, −d), or min(phi, d), d the distances to a solid; clamped to ±band. `phi`: the source's, within ±band.
BrickChange takeAwaySolid(const float* solid, float band, const float* phi, FloatBrick& out) noexcept;
BrickChange layOnSolid(const float* solid, float band, const float* phi, FloatBrick& out) noexcept;

/// What somebody else made of a brick: where `weight` is above zero and |phi| < `band` it may differ from phi by
/// `most`, elsewhere it becomes phi again. False where such a value is not finite; then `made` is undefined.
bool boundChange(const float* phi, const float* weight, float band, float most, float* made) noexcept;

/// The voxels of a brick with |phi| < `band`: bit y·8 + z of word x.
void bandBits(const float* phi, float band, uint64_t* bits) noexcept;

/// Whether the surface of a brick and that of a solid meet at an angle near it: somewhere in the brick both distances
/// are within the band, and their slopes differ by more than `most` along an axis. `sign`: 1 where the solid is added,
/// −1 where it is taken away.
bool meetAtAnAngle(const float* phi, const float* solid, float sign, float band, float most) noexcept;

/// Finishes a brick whose out.value was filled: clamps to ±band, turns −0 to 0, sets `inside`; `most`: the largest
/// change from `source`.
BrickChange sealBrick(const float* source, float band, FloatBrick& out, float& most) noexcept;

/// The largest over the ball of falloff(distance to the segment / radius) · strength and what `weight` holds already.
/// `shape`: as Falloff. Only for those rows of eight voxels along z whose bit (x·8 + y) is set in `rows`.
void ballWeights(const SweptBall& ball, int shape, float strength, float* weight, uint64_t rows = ~uint64_t{}) noexcept;

/// The rows, by such bits, in which a voxel of a brick is nearer to the surface than `within`.
[[nodiscard]] uint64_t rowsWithin(const float* phi, float within) noexcept;

/// Distances to the swept ball (negative inside).
void ballDistances(const SweptBall& ball, float* distance) noexcept;

/// Moves phi towards its 3×3×3 binomial mean by weight · amount where |phi| < band.
void smoothBrick(const float* padded, const float* weight, float amount, float band, float* out) noexcept;

/// Redistancing begins: writes |phi| to `u` around the brick and at its voxels beside a sign change along an axis,
/// whose bits it sets in `frozen`; `band` elsewhere.
void startDistance(const float* padded, float band, uint64_t* frozen, float* u) noexcept;

/// Where a field is no distance near its surface: `u` at frozen voxels becomes |phi| over the length of its gradient
/// there, but at creases of true distances, where both sides of a voxel differ. `frozen` and `u` as startDistance left
/// them. Only where |phi| ≥ `least`.
void renewNearDistance(const float* padded, const uint64_t* frozen, float least, float* u) noexcept;

/// One Jacobi pass of the eikonal equation |∇u| = 1 (first-order Godunov upwind): out = solution from the six
/// neighbours, at most `band`; voxels whose bit in `frozen` is set keep their value. Computes those rows of eight
/// voxels along z whose bit (x·8 + y) is set in `rows` and writes them to `out`, a brick's 512 values; the rows that
/// differ.
uint64_t eikonalPass(const float* padded, const uint64_t* frozen, uint64_t rows, float band, float* out) noexcept;

/// Redistancing ends: u with the sign of phi where that differs from phi by at least `tolerance`, phi elsewhere; 512
/// values each.
BrickChange settleDistance(const float* phi, const float* u, float band, float tolerance, FloatBrick& out) noexcept;

}  // namespace argil::clay
