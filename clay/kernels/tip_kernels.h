#pragma once
// Arithmetic of swept tips; compiled once per SIMD target. Same rules as brush_kernels.h.

namespace argil::clay {

/// A tip on its way, in its own axes, relative to the middle of a brick; voxels.
struct SweptAxes {
  float axes[9];  ///< Column by column: x, y, z of the tip's x axis, ...
  float a[3];     ///< Start, in the brick's axes.
  float d[3];     ///< Way, in the tip's axes.
  float half[3];  ///< Half axes or half edges at the start.
  float growth;   ///< Of all of them on the way, as a share of the start's.
  float round;    ///< Box: radius of its edges at the start.
};

/// Distances of a brick's voxels to the swept solid.
void ellipsoidDistances(const SweptAxes& tip, float* distance) noexcept;
void boxDistances(const SweptAxes& tip, float* distance) noexcept;

}  // namespace argil::clay
