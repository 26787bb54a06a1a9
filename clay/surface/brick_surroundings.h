#pragma once
// The field around a brick, as the vertices at creases look at it.

#include <array>

#include "clay/store/sampler.h"

namespace argil::clay {

/// The voxels from two below a brick's lowest one to three past its highest one: the corners of its cells and of two
/// more on each side. Voxels and cells are counted from the lowest voxel, so the brick's own begin at kMargin.
class BrickSurroundings {
 public:
  static constexpr int kMargin = 2;
  static constexpr int kVoxels = kBrickEdge + 1 + 2 * kMargin, kCells = kVoxels - 1;
  static constexpr int kStepY = 16, kStepX = kVoxels * kStepY;  ///< From a voxel to the next; 1 along z.

  /// Which voxels are read along each axis; `high` is the last one.
  struct Range {
    std::array<int, 3> low{0, 0, 0}, high{kVoxels - 1, kVoxels - 1, kVoxels - 1};
  };

  /// Reads the voxels in `range`; of others nothing can be told. Bricks outside of it are not looked at.
  void read(Sampler& field, Coord brick, const Range& range);

  /// Bit z: the voxel of that row is inside. Only of what was read.
  [[nodiscard]] unsigned inside(int x, int y) const { return inside_[static_cast<size_t>(x * kVoxels + y)]; }

  /// The distance there, voxels.
  [[nodiscard]] const float* at(int x, int y, int z) const {
    return &phi_[static_cast<size_t>(x * kStepX + y * kStepY + z)];
  }

 private:
  std::array<float, kVoxels * kStepX> phi_;
  std::array<uint16_t, kVoxels * kVoxels> inside_;
};

}  // namespace argil::clay
