#pragma once
// Cells that lie on one face, and the plane that it has there.

#include <bit>
#include <cstdint>

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

/// The planes of the cells around a brick, each made when it is first asked for.
class TangentPlanes {
 public:
  /// `around` must stand as long as this does; only cells whose corners it has read may be asked for. A cell that bends
  /// by more than `flat` (RMS, voxels) lies on no one face.
  TangentPlanes(const BrickSurroundings& around, float flat, float slight = 0, float strong = 0);
  /// The cells that bend by more than `slight` and by more than `strong`.
  [[nodiscard]] const BlockCells& slightlyBent() const { return cells_.slight; }
  [[nodiscard]] const BlockCells& bent() const { return cells_.strong; }

  /// The cells up to two steps away along each axis from the cell x, y, z (counted as in BrickSurroundings) that lie on
  /// one face: their planes, appended to `out`, which has room for all 125; how many. None has a cell that is bent, has
  /// hardly a slope, or is so far from the surface that it sees other faces too.
  size_t around(int x, int y, int z, TangentPlane* out);
  /// Whether none of them is turned by `most` (1 − the cosine) or more from the one that counts most at `p`, voxels
  /// from the brick's lowest one.
  [[nodiscard]] bool agreeAround(int x, int y, int z, const Vec3f& p, float most);

 private:
  static constexpr int kCells = BrickSurroundings::kCells;
  static_assert(kCells == kBlockCells);

  // Of the cells of a row whose bits are set, those that have a plane.
  unsigned known(int x, int y, unsigned cells) {
    const unsigned maybe = cells & cells_.flatNear[x][y];
    for (unsigned left = maybe & ~asked_[x][y]; left != 0; left &= left - 1) {
      const int z = std::countr_zero(left);
      if (fit(x, y, z)) known_[x][y] = static_cast<uint16_t>(known_[x][y] | 1u << z);
    }
    asked_[x][y] = static_cast<uint16_t>(asked_[x][y] | maybe);
    return known_[x][y] & cells;
  }
  bool fit(int x, int y, int z);

  const BrickSurroundings& around_;
  float flat2_;
  SortedCells cells_;
  BlockCells asked_{}, known_{};
  TangentPlane planes_[kCells][kCells][kCells];
  BlockNormals normals_;
};

}  // namespace argil::clay
