#pragma once
// Means of a brick's distances, and distances from means; compiled once per SIMD target.

#include "clay/kernels/shaping_kernels.h"

namespace argil::clay {

/// Means of 3×3×3 voxels `spacing` (1 to 4) apart, with binomial weights. `broad` needs that many voxels around the
/// brick.
void broadMean(const float* broad, int spacing, float* mean) noexcept;
/// Means two voxels apart of means one apart: of 7×7×7 voxels. `broad` needs three around the brick.
void broadMeanOfMeans(const float* broad, float* mean) noexcept;
/// Means eight voxels apart: of the same voxels of a brick and of those around it (kAroundSteps), 512 values each.
void farMean(const float* const (&around)[27], float* mean) noexcept;

/// What `passes` (0 to 4) of such means one voxel apart come to, rounded once, less `shift`, and ±`band` at most;
/// returns the smallest size of all. `broad` needs that many voxels around the brick.
float broadMeans(const float* broad, int passes, float shift, float band, float* mean) noexcept;

/// Values of a brick by a table of what stands for sizes 0, 1/`scale`, 2/`scale` and so on (kBendSteps and one more,
/// the last twice), straight between two; signs stay. Sizes beyond the table have its last value.
inline constexpr int kBendSteps = 256;
void bendValues(const float (&table)[kBendSteps + 2], float scale, float* values) noexcept;

}  // namespace argil::clay
