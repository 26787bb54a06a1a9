#include "clay/store/change_in_parts.h"

#include <algorithm>

namespace argil::clay {

namespace {

// Puts a brick of a tile's distances into its place.
void linkFar(Editor& editor, Coord coord, Tile tile) {
  Brick* brick = editor.newStoredBrick(coord);
  const bool inside = tile == Tile::inside;
  const float band = editor.grid().band;
  if (editor.step() == 0)
    std::fill_n(static_cast<FloatBrick*>(brick)->value, kBrickVoxels, inside ? -band : band);
  else
    std::fill_n(static_cast<FixedBrick*>(brick)->code, kBrickVoxels,
                static_cast<int16_t>(inside ? -kMostCode : kMostCode));
  std::fill_n(brick->inside, kBrickEdge, inside ? ~uint64_t{0} : 0);
  editor.link(brick);
}

}  // namespace

void ChangeInParts::link(size_t i, FloatBrick* brick, bool inBand) {
  editor_.link(brick, inBand);
  const Slot now = editor_.find(bricks_[i]);
  if (!now.isTile()) return;
  endsAs_[i] = now == Slot(Tile::inside) ? Tile::inside : Tile::outside;
  linkFar(editor_, bricks_[i], *endsAs_[i]);
}

void ChangeInParts::done(size_t count) {
  // In their order no neighbour of a brick comes later than this.
  constexpr Coord kLast{1, 1, 1};
  for (; settled_ < count && (count == bricks_.size() || bricks_[settled_] + kLast < bricks_[count]); ++settled_)
    if (endsAs_[settled_]) editor_.setTile(bricks_[settled_], *endsAs_[settled_]);
}

}  // namespace argil::clay
