#pragma once
// Cells that lie on one face, and the plane that it has there.

#include <cstddef>

#include "clay/base/vec.h"
#include "clay/kernels/crease_kernels.h"
#include "clay/surface/brick_surroundings.h"

namespace argil::clay {

/// The linear field that fits a cell which lies on one face.
struct TangentPlane {
  Vec3f centre;        ///< Of the cell, voxels from the brick's lowest one.
  Vec3f normal;        ///< Unit, outwards.
  float distance = 0;  ///< Signed, of the centre.
  float quality = 0;   ///< 0 to 1: how well it fits.
};

/// Mean square of what a linear field leaves of a cell's eight corners, voxels²: the four of its eight Walsh
/// coefficients that no linear field has. `low` is the lowest corner; the steps lead to the next voxel along x and y.
[[nodiscard]] inline float bendOf(const float* low, int stepX, int stepY) {
  const float* high = low + stepX;
  // Sums and differences along z, for each (x, y).
  const float a = low[0] + low[1], b = low[stepY] + low[stepY + 1], c = high[0] + high[1],
              d = high[stepY] + high[stepY + 1];
  const float e = low[1] - low[0], f = low[stepY + 1] - low[stepY], g = high[1] - high[0],
              h = high[stepY + 1] - high[stepY];
  const float xy = (a - b) - (c - d), yz = (f - e) + (h - g), zx = (g + h) - (e + f), xyz = (e - f) - (g - h);
  return ((xy * xy + yz * yz) + (zx * zx + xyz * xyz)) * (1.0f / 64);
}

/// The planes of the cells around a brick.
class TangentPlanes {
 public:
  /// Of the cells whose corners `around` has read. A cell that bends by `flat` (RMS, voxels) or more lies on no one
  /// face. About a microsecond.
  TangentPlanes(const BrickSurroundings& around, float flat, float slight = 0, float strong = 0);
  /// The cells that bend by more than `slight` and by more than `strong`.
  [[nodiscard]] const BlockCells& slightlyBent() const { return fits_.slight; }
  [[nodiscard]] const BlockCells& bent() const { return fits_.strong; }

  /// The cells up to two steps away along each axis from the cell x, y, z (counted as in BrickSurroundings) that lie on
  /// one face: their planes, appended to `out`, which has room for all 125; how many.
  size_t around(int x, int y, int z, TangentPlane* out) const;
  /// Whether none of them is turned by `most` (1 − the cosine) or more from the one that counts most at `p`, voxels
  /// from the brick's lowest one.
  [[nodiscard]] bool agreeAround(int x, int y, int z, const Vec3f& p, float most) const;

 private:
  static_assert(BrickSurroundings::kCells == kBlockCells);
  CellFits fits_;
};

}  // namespace argil::clay
