#include "clay/store/version.h"

#include <cmath>
#include <cstring>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/base/hash.h"
#include "clay/store/tree.h"

namespace argil::clay {

void Grid::check() const {
  if (!(voxelMm >= 1e-3 && voxelMm <= 1e3))
    throw Error(fmt::format("voxel size {:g} mm: give one from 0.001 to 1000 mm", voxelMm));
  for (int i = 0; i < 3; ++i)
    if (!(std::abs(originMm[i]) <= 1e6))
      throw Error(fmt::format("grid origin ({}, {}, {}) mm: move the model to within 1e6 mm of zero", originMm.x(),
                              originMm.y(), originMm.z()));
  if (!(band >= 2 && band <= 8)) throw Error(fmt::format("narrow band of {} voxels: give one from 2 to 8", band));
}

uint64_t VersionStats::bytes() const {
  return bricks * brickBytes(precision) + channelBricks * sizeof(ChannelBrick) + nodes * sizeof(Node);
}

Version makeVersion(std::unique_ptr<VersionRecord> made) {
  VersionRecord* const record = made.get();
  std::shared_ptr<const VersionRecord> handle(made.release(), [](const VersionRecord* dropped) {
    auto* mine = const_cast<VersionRecord*>(dropped);
    const std::shared_ptr<Store> keep = std::move(mine->store);  // may be the last: the store goes after this
    if (!mine->isMade) {
      delete mine;
      return;
    }
    const std::lock_guard lock(keep->state().mutex);
    keep->state().dropped.push_back(mine);
    keep->state().due = true;
  });
  Store::State& state = record->store->state();
  const std::lock_guard lock(state.mutex);
  // Dropping must not need memory.
  if (state.versions >= state.dropped.capacity()) state.dropped.reserve(2 * state.versions + 8);
  if (record->parent) record->parent->children.push_back(record);
  ++state.versions;
  record->isMade = true;
  return Version(std::move(handle));
}

Version Version::empty(std::shared_ptr<Store> store, const Grid& grid) {
  grid.check();
  const float step = stepOf(store->precision(), grid.band);
  if (step != 0 && static_cast<float>(kMostCode) * step != grid.band)
    throw Error(
        fmt::format("a narrow band of {} voxels cannot be told in 16 bits: give a rounder one, as 3", grid.band));
  auto record = std::make_unique<VersionRecord>();
  record->grid = grid;
  record->id = store->state().nextId++;
  record->stats.precision = store->precision();
  record->step = step;
  record->store = std::move(store);
  return makeVersion(std::move(record));
}

const Grid& Version::grid() const {
  return record_->grid;
}
uint64_t Version::id() const {
  return record_->id;
}
const std::shared_ptr<Store>& Version::store() const {
  return record_->store;
}
VersionStats Version::stats() const {
  return record_->stats;
}

Slot Version::find(Coord brick) const noexcept {
  return inReach(brick) ? slotOf(descend(record_->roots[kDistanceTree], brick, 0)) : Slot(Tile::outside);
}

ChannelSlot Version::find(Channel channel, Coord brick) const noexcept {
  return inReach(brick) ? channelSlotOf(descend(rootOf(*record_, channel), brick, 0)) : ChannelSlot();
}

bool Version::has(Channel channel) const noexcept {
  return rootOf(*record_, channel) != 0;
}

namespace {

template <class Leaf>
void visitBricks(Link link, int level, const std::function<void(const Leaf&)>& visit) {
  if (isTile(link)) return;
  if (level == 0) {
    visit(*reinterpret_cast<const Leaf*>(link));
    return;
  }
  for (const Link child : reinterpret_cast<const Node*>(link)->child) visitBricks(child, level - 1, visit);
}

// Where both are tiles: a full channel brick beside an empty one is a difference; of distances an inside tile and an
// outside one have no surface.
template <bool tiles, class Visit>
void visitDifference(Link a, Link b, int level, Coord first, const Visit& visit) {
  if (a == b || (!tiles && isTile(a) && isTile(b))) return;
  if (level == 0) {
    visit(first, a, b);
    return;
  }
  const int step = 1 << (3 * (level - 1));
  for (int i = 0; i < 512; ++i) {
    const Link ca = isTile(a) ? a : reinterpret_cast<const Node*>(a)->child[i];
    const Link cb = isTile(b) ? b : reinterpret_cast<const Node*>(b)->child[i];
    if (ca != cb) visitDifference<tiles>(ca, cb, level - 1, first + Coord{i >> 6, (i >> 3) & 7, i & 7} * step, visit);
  }
}

template <class Leaf>
void hashTree(Link link, int level, Hasher& hasher) {
  hasher.add(isTile(link) ? link : 2 + static_cast<uint64_t>(level));
  if (isTile(link)) return;
  if (level == 0) {
    const auto* leaf = reinterpret_cast<const Leaf*>(link);
    if constexpr (std::is_same_v<Leaf, ChannelBrick>)
      hasher.add(leaf->value, sizeof leaf->value);
    else if (leaf->step == 0)
      hasher.add(static_cast<const FloatBrick*>(leaf)->value, sizeof(BrickValues));
    else
      hasher.add(static_cast<const FixedBrick*>(leaf)->code, sizeof FixedBrick::code);
    return;
  }
  for (const Link child : reinterpret_cast<const Node*>(link)->child) hashTree<Leaf>(child, level - 1, hasher);
}

constexpr Coord kTreeFirst{-kBrickOrigin, -kBrickOrigin, -kBrickOrigin};

}  // namespace

void Version::forEachBrick(const std::function<void(const Brick&)>& visit) const {
  visitBricks(record_->roots[kDistanceTree], kTreeLevels, visit);
}

void Version::forEachBrick(Channel channel, const std::function<void(const ChannelBrick&)>& visit) const {
  visitBricks(rootOf(*record_, channel), kTreeLevels, visit);
}

void Version::forEachDifference(const Version& a, const Version& b,
                                const std::function<void(Coord, Slot, Slot)>& visit) {
  visitDifference<false>(a.record_->roots[kDistanceTree], b.record_->roots[kDistanceTree], kTreeLevels, kTreeFirst,
                         [&](Coord at, Link x, Link y) { visit(at, slotOf(x), slotOf(y)); });
}

void Version::forEachDifference(Channel channel, const Version& a, const Version& b,
                                const std::function<void(Coord, ChannelSlot, ChannelSlot)>& visit) {
  visitDifference<true>(rootOf(*a.record_, channel), rootOf(*b.record_, channel), kTreeLevels, kTreeFirst,
                        [&](Coord at, Link x, Link y) { visit(at, channelSlotOf(x), channelSlotOf(y)); });
}

uint64_t Version::hash() const {
  Hasher hasher;
  const Grid& g = record_->grid;
  const double numbers[] = {g.voxelMm, g.originMm.x(), g.originMm.y(), g.originMm.z(), g.band};
  hasher.add(numbers, sizeof numbers);
  hashTree<Brick>(record_->roots[kDistanceTree], kTreeLevels, hasher);
  // What is absent counts for nothing: a version without channels has the hash of its distances alone.
  for (const Channel channel : kAllChannels) {
    if (!has(channel)) continue;
    hasher.add(0x100 + static_cast<uint64_t>(channel));
    hashTree<ChannelBrick>(rootOf(*record_, channel), kTreeLevels, hasher);
  }
  return hasher.value();
}

uint64_t Version::activeVoxels() const {
  uint64_t count = 0;
  const float band = record_->grid.band;
  forEachBrick([&](const Brick& brick) {
    BrickValues scratch;
    for (const float phi : brick.values(scratch)) count += std::abs(phi) < band;
  });
  return count;
}

}  // namespace argil::clay
