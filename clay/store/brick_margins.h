#pragma once
// Bricks with voxels of their neighbours around them. This module's own.

#include <array>
#include <cstddef>
#include <span>
#include <vector>

#include "clay/kernels/shaping_kernels.h"
#include "clay/store/brick_set.h"
#include "clay/store/sampler.h"

namespace argil::clay {

/// Neighbours across the faces, below and above along x, y, z: face / 2 is the axis.
inline constexpr std::array<Coord, 6> kFaceSteps{{{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

/// For each of `bricks` (sorted, each once) the indices among them of the bricks `steps` away, −1 where there is none.
/// Cost: one walk along `bricks` a step.
template <size_t count>
std::vector<std::array<ptrdiff_t, count>> besideEach(std::span<const Coord> bricks,
                                                     const std::array<Coord, count>& steps) {
  std::vector<std::array<ptrdiff_t, count>> beside(bricks.size());
  for (size_t k = 0; k < count; ++k) {
    size_t at = 0;
    for (size_t i = 0; i < bricks.size(); ++i) {
      const Coord wanted = bricks[i] + steps[k];
      while (at < bricks.size() && bricks[at] < wanted) ++at;
      beside[i][k] = at < bricks.size() && bricks[at] == wanted ? static_cast<ptrdiff_t>(at) : -1;
    }
  }
  return beside;
}

/// Writes brick `coord` and one voxel around it to `padded` (kPaddedSize values, those within rows that stand for no
/// voxel are left as they are).
void gatherPadded(Sampler& field, Coord coord, float* padded) noexcept;

/// A brick's values and `margin` (1 to 4) around them, laid out by broadOffset. `instead`, if any: for each of the
/// bricks around (kAroundSteps) its 512 values that count instead of the clay's, or null.
void gatherBroad(Sampler& field, Coord coord, int margin, float* broad, const float* const* instead = nullptr) noexcept;

}  // namespace argil::clay
