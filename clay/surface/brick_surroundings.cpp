#include "clay/surface/brick_surroundings.h"

#include <algorithm>

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
      for (int z = low[2]; z <= high[2];) {
        const int vz = z - kMargin + kBrickEdge, in = vz % kBrickEdge, n = std::min(kBrickEdge - in, high[2] + 1 - z);
        const Slot slot = row[vz / kBrickEdge];
        float* out = &phi_[static_cast<size_t>(x * kStepX + y * kStepY + z)];
        if (const Brick* b = slot.brick())
          b->read(Brick::offset(vx % kBrickEdge, vy % kBrickEdge, in), n, out, step);
        else
          std::fill_n(out, n, slot.phi(0, band));
        z += n;
      }
    }
}

}  // namespace argil::clay
