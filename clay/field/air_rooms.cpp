#include "clay/field/air_rooms.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <tuple>

#include "clay/field/distance_box.h"
#include "clay/field/region_work.h"
#include "clay/field/work_rooms.h"

namespace argil::clay {

namespace {

constexpr float kSteps = kFree - 1;
// Distances that are cut off at the radius are free, whatever their last bit.
constexpr float kSlack = 1 + 2e-6f;

Coord voxelIn(Coord brick, int at) {
  return brick * kBrickEdge + Coord{at >> 6, (at >> 3) & 7, at & 7};
}

}  // namespace

AirRooms::AirRooms(const Version& version, double radius, int threads, const WorkPart& part) {
  measure(version, radius, threads, part.part(0, 0.9));
  makeRows(version);
  for (const Row& row : rows_) {
    joinAlong(row);
    joinBeside(row, rowAt(row.x + 1, row.y), 0, true);
    joinBeside(row, rowAt(row.x, row.y + 1), 1, true);
    // Beside nothing is the outside.
    if (!rowAt(row.x - 1, row.y)) joinBeside(row, nullptr, 0, false);
    if (!rowAt(row.x, row.y - 1)) joinBeside(row, nullptr, 1, false);
  }
  part.step(1);
}

void AirRooms::measure(const Version& version, double radius, int threads, const WorkPart& part) {
  const std::vector<Coord> regions = regionsNear(version, static_cast<int>(std::ceil(radius)) + 1);
  std::vector<std::vector<Levels>> found(regions.size());
  const auto reach = static_cast<float>(radius);
  const float stepsAVoxel = kSteps / reach * kSlack, band = version.grid().band;
  forEachWithRoom<DistanceBox>(regions.size(), threads, part, [&](size_t i, DistanceBox& box) {
    const Coord low = regions[i] * kRegionVoxels;
    if (!box.fill(version, low, {kRegionVoxels, kRegionVoxels, kRegionVoxels}, {.inside = band, .outside = reach}))
      return;
    const Coord first = regions[i] * kRegionBricks;
    for (int b = 0; b < kRegionBricks * kRegionBricks * kRegionBricks; ++b) {
      Levels brick{first + Coord{b >> 6, (b >> 3) & 7, b & 7}, {}};
      AirLevel most = 0, least = kFree;
      for (int row = 0; row < kBrickEdge * kBrickEdge; ++row) {
        const float* phi = box.row(voxelIn(brick.coord, row * kBrickEdge));
        AirLevel* const levels = &brick.level[static_cast<size_t>(row * kBrickEdge)];
        for (int z = 0; z < kBrickEdge; ++z) {
          const int level = static_cast<int>(phi[z] * stepsAVoxel) + (phi[z] > 0 ? 1 : 0);
          levels[z] = static_cast<AirLevel>(std::clamp(level, 0, int{kFree}));
        }
        for (int z = 0; z < kBrickEdge; ++z) most = std::max(most, levels[z]), least = std::min(least, levels[z]);
      }
      const bool clay = most == 0, free = least == kFree;
      // What is free and no tile is kept, since gaps are told by tiles (makeRows()).
      if (!clay && (!free || version.find(brick.coord).brick())) found[i].push_back(brick);
    }
  });
  std::vector<const Levels*> order;
  for (const std::vector<Levels>& each : found)
    for (const Levels& brick : each) order.push_back(&brick);
  std::sort(order.begin(), order.end(), [](const Levels* a, const Levels* b) { return a->coord < b->coord; });
  bricks_.reserve(order.size());
  for (const Levels* each : order) bricks_.push_back(*each);
}

void AirRooms::makeRows(const Version& version) {
  parts_.push_back({kNone, kFullMask});
  itemOf_.resize(bricks_.size());
  at_.reserve(bricks_.size());
  for (uint32_t i = 0; i < bricks_.size(); ++i) {
    const Coord c = bricks_[i].coord;
    at_.emplace(c, i);
    if (rows_.empty() || rows_.back().x != c.x || rows_.back().y != c.y) {
      const auto first = static_cast<uint32_t>(items_.size());
      rows_.push_back({c.x, c.y, first, first});
    } else if (const int32_t after = items_.back().to; after < c.z) {
      const Slot slot = version.find({c.x, c.y, after});
      Item gap{after, c.z, kNone, static_cast<uint32_t>(parts_.size()), static_cast<uint32_t>(parts_.size())};
      if (!slot.brick() && slot.tile() == Tile::outside) {
        parts_.push_back({static_cast<uint32_t>(items_.size()), kFullMask});
        ++gap.end;
      }
      items_.push_back(gap);
    }
    BrickMask left{};
    for (int v = 0; v < kBrickVoxels; ++v)
      left[static_cast<size_t>(v >> 6)] |= uint64_t{bricks_[i].level[static_cast<size_t>(v)] == kFree} << (v & 63);
    Item item{c.z, c.z + 1, i, static_cast<uint32_t>(parts_.size()), 0};
    itemOf_[i] = static_cast<uint32_t>(items_.size());
    while (std::any_of(left.begin(), left.end(), [](uint64_t w) { return w != 0; }))
      parts_.push_back({itemOf_[i], takeComponent(left)});
    item.end = static_cast<uint32_t>(parts_.size());
    items_.push_back(item);
    rows_.back().end = static_cast<uint32_t>(items_.size());
  }
  sets_ = JoinedSets(parts_.size());
}

void AirRooms::joinAlong(const Row& row) {
  constexpr int kZ = 2;
  const auto withOutside = [&](const Item& item, bool up) {
    for (uint32_t p = item.first; p < item.end; ++p)
      if (up ? touch(parts_[p].mask, kFullMask, kZ) : touch(kFullMask, parts_[p].mask, kZ)) join(p, 0);
  };
  withOutside(items_[row.first], false);
  withOutside(items_[row.end - 1], true);
  for (uint32_t i = row.first; i + 1 < row.end; ++i)
    for (uint32_t a = items_[i].first; a < items_[i].end; ++a)
      for (uint32_t b = items_[i + 1].first; b < items_[i + 1].end; ++b)
        if (touch(parts_[a].mask, parts_[b].mask, kZ)) join(a, b);
}

void AirRooms::joinBeside(const Row& row, const Row* next, int axis, bool up) {
  // Of what stands beside one brick.
  const auto meet = [&](const Item& a, const Item& b) {
    for (uint32_t p = a.first; p < a.end; ++p)
      for (uint32_t q = b.first; q < b.end; ++q)
        if (touch(parts_[p].mask, parts_[q].mask, axis)) join(p, q);
  };
  const auto withOutside = [&](const Item& item) {
    for (uint32_t p = item.first; p < item.end; ++p)
      if (up ? touch(parts_[p].mask, kFullMask, axis) : touch(kFullMask, parts_[p].mask, axis)) join(p, 0);
  };
  if (!next) {
    for (uint32_t i = row.first; i < row.end; ++i) withOutside(items_[i]);
    return;
  }
  uint32_t i = row.first, j = next->first;
  while (i < row.end && j < next->end) {
    const Item &a = items_[i], &b = items_[j];
    if (a.from < b.to && b.from < a.to) meet(a, b);
    // Before the first and behind the last of a row is the outside.
    if (j == next->first && a.from < b.from) withOutside(a);
    if (a.to <= b.to)
      ++i;
    else
      ++j;
  }
  for (; i < row.end; ++i) withOutside(items_[i]);
  const int32_t low = items_[row.first].from, high = items_[row.end - 1].to;
  for (j = next->first; j < next->end; ++j)
    if (items_[j].from < low || items_[j].to > high)
      for (uint32_t q = items_[j].first; q < items_[j].end; ++q)
        if (touch(kFullMask, parts_[q].mask, axis)) join(q, 0);
}

const AirRooms::Row* AirRooms::rowAt(int32_t x, int32_t y) const {
  const auto at = std::lower_bound(rows_.begin(), rows_.end(), std::tie(x, y),
                                   [](const Row& row, const auto& to) { return std::tie(row.x, row.y) < to; });
  return at != rows_.end() && at->x == x && at->y == y ? &*at : nullptr;
}

uint32_t AirRooms::brickAt(Coord coord) const {
  const auto at = at_.find(coord);
  return at != at_.end() ? at->second : kNone;
}

uint32_t AirRooms::partOf(const Item& item, int at) const {
  for (uint32_t p = item.first; p < item.end; ++p)
    if (item.brick == kNone || holds(parts_[p].mask, at)) return p;
  return kNone;
}

const AirRooms::Item* AirRooms::itemAt(Coord coord) const {
  const Row* row = rowAt(coord.x, coord.y);
  if (!row) return nullptr;
  const auto first = items_.begin() + row->first, end = items_.begin() + row->end;
  const auto after = std::upper_bound(first, end, coord.z, [](int32_t z, const Item& item) { return z < item.from; });
  return after != first && coord.z < std::prev(after)->to ? &*std::prev(after) : nullptr;
}

AirRooms::Voxel AirRooms::voxel(Coord voxel) const {
  const Coord coord = voxel >> kBrickBits;
  if (const uint32_t brick = brickAt(coord); brick != kNone) {
    const int at = Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7);
    const AirLevel level = bricks_[brick].level[static_cast<size_t>(at)];
    return {brick, static_cast<int16_t>(at), level, level == kFree ? roomAt(brick, at) : kNone};
  }
  const Item* item = itemAt(coord);
  const uint32_t room = item ? partOf(*item, 0) : 0;
  return {kNone, -1, room == kNone ? AirLevel{0} : kFree, room};
}

BrickMask AirRooms::closedIn(uint32_t brick, Coord coord) {
  BrickMask mask{};
  const Item* item = brick != kNone ? &items_[itemOf_[brick]] : itemAt(coord);
  if (!item) return mask;
  for (uint32_t p = item->first; p < item->end; ++p)
    if (root(p) != 0)
      for (size_t x = 0; x < mask.size(); ++x) mask[x] |= parts_[p].mask[x];
  return mask;
}

std::vector<AirRooms::Room> AirRooms::closedRooms() {
  std::vector<Room> rooms;
  std::vector<uint32_t> number(parts_.size(), kNone);
  for (uint32_t p = 1; p < parts_.size(); ++p) {
    const uint32_t r = root(p);
    if (r == 0) continue;
    const Item& item = items_[parts_[p].item];
    const Row& row = *std::prev(std::upper_bound(rows_.begin(), rows_.end(), parts_[p].item,
                                                 [](uint32_t i, const Row& each) { return i < each.first; }));
    if (number[r] == kNone) {
      number[r] = static_cast<uint32_t>(rooms.size());
      int at = 0;
      while (!holds(parts_[p].mask, at)) ++at;
      rooms.push_back({r, 0, voxelIn({row.x, row.y, item.from}, at)});
    }
    uint64_t voxels = 0;
    for (const uint64_t word : parts_[p].mask) voxels += static_cast<uint64_t>(std::popcount(word));
    rooms[number[r]].voxels += voxels * static_cast<uint64_t>(item.to - item.from);
  }
  return rooms;
}

std::vector<uint32_t> AirRooms::bricksOfClosedRooms() {
  std::vector<uint32_t> bricks;
  const auto add = [&](Coord coord) {
    if (const uint32_t brick = brickAt(coord); brick != kNone) bricks.push_back(brick);
  };
  for (const Row& row : rows_)
    for (uint32_t i = row.first; i < row.end; ++i) {
      bool closed = false;
      for (uint32_t p = items_[i].first; p < items_[i].end; ++p) closed |= root(p) != 0;
      if (!closed) continue;
      for (int32_t z = items_[i].from; z < items_[i].to; ++z)
        for (const Coord step : {Coord{0, 0, 0}, Coord{1, 0, 0}, Coord{-1, 0, 0}, Coord{0, 1, 0}, Coord{0, -1, 0},
                                 Coord{0, 0, 1}, Coord{0, 0, -1}})
          add(Coord{row.x, row.y, z} + step);
    }
  std::sort(bricks.begin(), bricks.end());
  bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
  return bricks;
}

}  // namespace argil::clay
