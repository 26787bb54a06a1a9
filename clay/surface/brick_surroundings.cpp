#include "clay/surface/brick_surroundings.h"

#include <algorithm>
#include <utility>

namespace argil::clay {

void BrickSurroundings::read(Sampler& field, Coord brick, const Range& range) {
  const float band = field.band(), step = field.step();
  const auto& [low, high] = range;
  std::array<int, 3> first, last;  // of the three bricks along each axis
  for (size_t axis = 0; axis < 3; ++axis) {
    first[axis] = low[axis] < kMargin ? 0 : 1;
    last[axis] = high[axis] >= kMargin + kBrickEdge ? 2 : 1;
  }
  Slot slots[3][3][3];
  for (int x = first[0]; x <= last[0]; ++x)
    for (int y = first[1]; y <= last[1]; ++y)
      for (int z = first[2]; z <= last[2]; ++z) slots[x][y][z] = field.slot(brick + Coord{x - 1, y - 1, z - 1});
  for (int x = low[0]; x <= high[0]; ++x)
    for (int y = low[1]; y <= high[1]; ++y) {
      const int vx = x - kMargin + kBrickEdge, vy = y - kMargin + kBrickEdge;
      const Slot(&row)[3] = slots[vx / kBrickEdge][vy / kBrickEdge];
      const int offset = Brick::offset(vx % kBrickEdge, vy % kBrickEdge, 0);
      float* out = &phi_[static_cast<size_t>(x * kStepX + y * kStepY)];
      unsigned inside = 0;
      // Pieces of one length each: a copy is a few instructions.
      const auto piece = [&]<int from, int count>(const Slot slot, std::integer_sequence<int, from, count>, int at) {
        unsigned bits = slot.tile() == Tile::inside ? 0xff : 0;
        if (const Brick* b = slot.brick()) {
          b->read(offset + from, count, out + at, step);
          bits = static_cast<unsigned>(b->inside[offset >> 6] >> (offset & 63));
        } else {
          std::fill_n(out + at, count, slot.phi(0, band));
        }
        inside |= (bits >> from & ((1u << count) - 1)) << at;
      };
      if (first[2] == 0) piece(row[0], std::integer_sequence<int, kBrickEdge - kMargin, kMargin>(), 0);
      piece(row[1], std::integer_sequence<int, 0, kBrickEdge>(), kMargin);
      if (last[2] == 2) piece(row[2], std::integer_sequence<int, 0, kMargin + 1>(), kMargin + kBrickEdge);
      inside_[static_cast<size_t>(x * kVoxels + y)] = static_cast<uint16_t>(inside);
    }
}

}  // namespace argil::clay
