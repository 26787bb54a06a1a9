#include "clay/store/change_in_parts.h"

#include <algorithm>
#include <array>

#include "clay/store/brick_set.h"

namespace argil::clay {

namespace {

using Bits = std::array<uint64_t, kBrickEdge>;  // as Brick::inside

// For each of kAroundSteps the voxels of a brick that touch the brick there.
constexpr std::array<Bits, kBricksAround> kTouching = [] {
  constexpr uint64_t kFirstZ = 0x0101010101010101, kLastY = uint64_t{0xff} << 56, kAll = ~uint64_t{0};
  std::array<Bits, kBricksAround> touching{};
  for (size_t k = 0; k < kBricksAround; ++k) {
    const Coord step = kAroundSteps[k];
    const uint64_t y = step.y == 0 ? kAll : step.y < 0 ? uint64_t{0xff} : kLastY,
                   z = step.z == 0 ? kAll : step.z < 0 ? kFirstZ : kFirstZ << 7;
    for (int x = 0; x < kBrickEdge; ++x)
      if (step.x == 0 || x == (step.x < 0 ? 0 : kBrickEdge - 1)) touching[k][static_cast<size_t>(x)] = y & z;
  }
  return touching;
}();

uint64_t insideOf(Tile tile) {
  return tile == Tile::inside ? ~uint64_t{0} : 0;
}
Tile tileOf(bool inside) {
  return inside ? Tile::inside : Tile::outside;
}

// Whether two sets differ in some voxel of a third.
bool differ(const Bits& a, const Bits& b, const Bits& among) {
  uint64_t some = 0;
  for (size_t x = 0; x < a.size(); ++x) some |= (a[x] ^ b[x]) & among[x];
  return some != 0;
}

Bits filled(Tile tile) {
  Bits bits;
  bits.fill(insideOf(tile));
  return bits;
}

}  // namespace

void ChangeInParts::putFar(size_t i, Tile tile) {
  Brick* brick = editor_.newStoredBrick(bricks_[i]);
  const float band = editor_.grid().band;
  if (editor_.step() == 0)
    std::fill_n(static_cast<FloatBrick*>(brick)->value, kBrickVoxels, tile == Tile::inside ? -band : band);
  else
    std::fill_n(static_cast<FixedBrick*>(brick)->code, kBrickVoxels,
                static_cast<int16_t>(tile == Tile::inside ? -kMostCode : kMostCode));
  std::fill_n(brick->inside, kBrickEdge, insideOf(tile));
  editor_.link(brick);
  endsAs_[i] = tile;
}

void ChangeInParts::link(size_t i, Slot was, FloatBrick* brick, bool inBand) {
  const Coord coord = bricks_[i];
  const Tile ifFar = tileOf(brick->value[0] < 0);
  Bits before = filled(was == Slot(Tile::inside) ? Tile::inside : Tile::outside), now;
  if (!was.isTile()) std::copy_n(was.brick()->inside, kBrickEdge, before.begin());
  std::copy_n(brick->inside, kBrickEdge, now.begin());
  editor_.link(brick, inBand);
  endsAs_[i] = std::nullopt;
  if (editor_.find(coord).isTile()) putFar(i, ifFar);
  // What stood there before met no surface here; where the signs are the same that is still so.
  if (before == now) return;
  for (size_t k = 0; k < kBricksAround; ++k) {
    if (!differ(before, now, kTouching[k])) continue;
    const Slot near = editor_.find(coord + kAroundSteps[k]);
    if (!near.isTile()) continue;
    const Tile tile = tileOf(near == Slot(Tile::inside));
    if (!differ(filled(tile), now, kTouching[k])) continue;
    // One that the change does not reach stands beside this brick at the end too: then its sign is the same.
    const auto at = std::lower_bound(bricks_.begin(), bricks_.end(), coord + kAroundSteps[k]);
    if (at != bricks_.end() && *at == coord + kAroundSteps[k]) putFar(static_cast<size_t>(at - bricks_.begin()), tile);
  }
}

void ChangeInParts::done(size_t count) {
  // In their order no neighbour of a brick comes later than this.
  constexpr Coord kLast{1, 1, 1};
  for (; settled_ < count && (count == bricks_.size() || bricks_[settled_] + kLast < bricks_[count]); ++settled_)
    if (endsAs_[settled_]) editor_.setTile(bricks_[settled_], *endsAs_[settled_]);
}

}  // namespace argil::clay
