#pragma once
// The bricks that the cells of a region read. For this module's files alone.

#include "clay/store/tree.h"

namespace argil::clay {

/// What stands at the 8×8×8 bricks of a region (64 voxels wide) and at those one step higher along each axis: eight
/// nodes of the tree, found once. The version must be held by somebody while it is used.
class RegionSlots {
 public:
  RegionSlots(const Version& version, Coord region) noexcept {
    for (int k = 0; k < 8; ++k) {
      const Coord brick = (region + Coord{k >> 2, (k >> 1) & 1, k & 1}) * 8;
      nodes_[k] = inReach(brick) ? descend(version.record()->roots[kDistanceTree], brick, 1) : linkOf(Tile::outside);
    }
  }

  /// At a brick of the region, 0 to 8 along each axis.
  [[nodiscard]] Slot at(int x, int y, int z) const noexcept {
    return child(nodes_[(x >> 3) << 2 | (y >> 3) << 1 | z >> 3], (x & 7) << 6 | (y & 7) << 3 | (z & 7));
  }
  /// At a brick of the region, 0 to 7 along each axis, and one step higher along each, as [x][y][z].
  void corner(int x, int y, int z, Slot (&out)[2][2][2]) const noexcept {
    if (x < 7 && y < 7 && z < 7 && !isTile(nodes_[0])) {
      const Link* first = &reinterpret_cast<const Node*>(nodes_[0])->child[x << 6 | y << 3 | z];
      for (int k = 0; k < 8; ++k)
        out[k >> 2][(k >> 1) & 1][k & 1] = slotOf(first[(k >> 2) << 6 | ((k >> 1) & 1) << 3 | (k & 1)]);
      return;
    }
    for (int k = 0; k < 8; ++k) out[k >> 2][(k >> 1) & 1][k & 1] = at(x + (k >> 2), y + ((k >> 1) & 1), z + (k & 1));
  }

 private:
  static Slot child(Link node, int index) {
    return slotOf(isTile(node) ? node : reinterpret_cast<const Node*>(node)->child[index]);
  }
  Link nodes_[8];
};

}  // namespace argil::clay
