#pragma once
// Bricks with voxels of their neighbours around them. This module's own.

#include <algorithm>
#include <array>
#include <cstring>

#include "clay/kernels/shaping_kernels.h"
#include "clay/store/sampler.h"

namespace argil::clay {

/// Neighbours across the faces, below and above along x, y, z: face / 2 is the axis.
inline constexpr std::array<Coord, 6> kFaceSteps{{{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

/// A brick's values and `margin` (1 to 4) around them, laid out by broadOffset. `instead` of a brick coordinate: values
/// that count instead of the clay's, or null.
template <class Instead>
void gatherBroad(Sampler& field, Coord coord, int margin, const Instead& instead, float* broad) {
  for (int i = 0; i < 27; ++i) {
    const int side[3] = {i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1};
    int begin[3], end[3];
    for (int k = 0; k < 3; ++k) {
      begin[k] = side[k] < 0 ? 4 - margin : side[k] == 0 ? 4 : 12;
      end[k] = side[k] < 0 ? 4 : side[k] == 0 ? 12 : 12 + margin;
    }
    const Coord at = coord + Coord{side[0], side[1], side[2]};
    const Slot slot = field.slot(at);
    const float* from = instead(at);
    const int count = end[2] - begin[2];
    for (int x = begin[0]; x < end[0]; ++x)
      for (int y = begin[1]; y < end[1]; ++y) {
        const int first = Brick::offset((x + 4) & 7, (y + 4) & 7, (begin[2] + 4) & 7);
        float* row = broad + broadOffset(x, y, begin[2]);
        if (from)
          std::copy_n(from + first, count, row);
        else if (slot.isTile())
          std::fill_n(row, count, slot.phi(0, field.band()));
        else
          slot.brick()->read(first, count, row, field.step());
      }
  }
}

/// Copies two layers of one brick's values, laid out by wideOffset, into its neighbour's margin; `to` is the neighbour
/// along +axis when `positive`.
inline void copyLayers(const float* from, float* to, int axis, bool positive) {
  const int source = positive ? 8 : 2, target = positive ? 0 : 10;
  if (axis == 2) {
    for (int x = 2; x < 10; ++x)
      for (int y = 2; y < 10; ++y)
        std::memcpy(to + wideOffset(x, y, target), from + wideOffset(x, y, source), 2 * sizeof(float));
    return;
  }
  for (int layer = 0; layer < 2; ++layer)
    for (int i = 2; i < 10; ++i) {
      const int t = axis == 0 ? wideOffset(target + layer, i, 2) : wideOffset(i, target + layer, 2);
      const int f = axis == 0 ? wideOffset(source + layer, i, 2) : wideOffset(i, source + layer, 2);
      std::memcpy(to + t, from + f, kBrickEdge * sizeof(float));
    }
}

}  // namespace argil::clay
