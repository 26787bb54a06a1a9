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
  static constexpr int kStepX = kVoxels * kVoxels, kStepY = kVoxels;  ///< From a voxel to the next; 1 along z.

  /// Which voxels are read along each axis; `high` is the last one.
  struct Range {
    std::array<int, 3> low{0, 0, 0}, high{kVoxels - 1, kVoxels - 1, kVoxels - 1};
  };

  /// Reads the voxels in `range`; the others stay unknown. Bricks outside of it are not looked at.
  void read(Sampler& field, Coord brick, const Range& range);

  /// The distance there, voxels.
  [[nodiscard]] const float* at(int x, int y, int z) const {
    return &phi_[static_cast<size_t>(x * kStepX + y * kStepY + z)];
  }

 private:
  std::array<float, kVoxels * kVoxels * kVoxels> phi_;
};

}  // namespace argil::clay
