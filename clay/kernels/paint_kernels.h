#pragma once
// Weights of a brush on the surface itself: they are the same for all voxels along a normal, so that what is painted
// ends in a clean line, however the voxels lie. Compiled once per SIMD target.

#include "clay/kernels/brush_kernels.h"

namespace argil::clay {

/// Width in voxels over which the rim of a painted stamp fades, from nothing to all.
inline constexpr float kPaintRim = 2;

/// Steps from each voxel of a brick to its nearest point of the surface, −φ·∇φ/|∇φ|: three times 512 values. Zero where
/// |φ| ≥ `band`. `padded`: the field with one voxel around the brick; of what lies beyond the band there nothing
/// counts.
void surfaceFeet(const float* padded, float band, float* foot) noexcept;

/// Adds a ball to what `weight` and `cover` hold already: the larger of both. The weight is falloff · strength at the
/// foot of each voxel (1 for the constant falloff, up to the end of its rim). The cover is the share of the surface
/// around the foot that lies within the ball: a smooth step over kPaintRim voxels, around the ball's border for the
/// constant falloff and inside of it for all others. `shape`: as Falloff.
void paintWeights(const SweptBall& ball, int shape, float strength, const float* foot, float* weight,
                  float* cover) noexcept;

}  // namespace argil::clay
