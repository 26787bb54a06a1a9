#pragma once
// Cells that lie on one face, and the plane that it has there.

#include <array>
#include <cstdint>

#include "clay/base/vec.h"
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
  TangentPlanes(const BrickSurroundings& around, float flat) : around_(around), flat2_(flat * flat) {}

  /// Of a cell, counted as in BrickSurroundings; null where it is bent, has hardly a slope, or is so far from the
  /// surface that it sees other faces too.
  [[nodiscard]] const TangentPlane* at(int x, int y, int z) {
    const auto cell = static_cast<size_t>((x * kCells + y) * kCells + z);
    if (state_[cell] == 0) state_[cell] = fit(x, y, z, planes_[cell]) ? 2 : 1;
    return state_[cell] == 2 ? &planes_[cell] : nullptr;
  }

 private:
  static constexpr int kCells = BrickSurroundings::kCells;

  bool fit(int x, int y, int z, TangentPlane& out) const;

  const BrickSurroundings& around_;
  float flat2_;
  std::array<uint8_t, kCells * kCells * kCells> state_{};  // 0 unknown, 1 none, 2 known
  std::array<TangentPlane, kCells * kCells * kCells> planes_;
};

}  // namespace argil::clay
