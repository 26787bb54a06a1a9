#pragma once
// The air around clay by how far it is from it, and the rooms in it where a ball fits. This module's own.

#include <array>
#include <memory>
#include <span>
#include <unordered_map>
#include <vector>

#include "clay/base/joined_sets.h"
#include "clay/base/work_part.h"
#include "clay/field/brick_parts.h"
#include "clay/store/brick_set.h"
#include "clay/store/version.h"

namespace argil::clay {

/// A voxel's distance to the clay in steps of radius/254: 0 in the clay, kFree from the radius on.
using AirLevel = uint8_t;
inline constexpr AirLevel kFree = 255;

/// Rooms are what hangs together of free voxels, across faces; room 0 is the outside. Made once; then one thread.
class AirRooms {
 public:
  /// `radius` in voxels, at least kLeastNeckVoxels.
  AirRooms(const Version& version, double radius, int threads, const WorkPart& part);

  struct Voxel {
    uint32_t brick;  ///< Number of a brick, kNone where none has levels: all of it is free, or clay.
    int16_t at;      ///< Brick::offset, or −1 beside such a brick.
    AirLevel level;
    uint32_t room;  ///< Of a free voxel; joined with others later: ask root().
  };
  static constexpr uint32_t kNone = UINT32_MAX;

  /// Bricks that have levels, by coordinate.
  [[nodiscard]] size_t bricks() const { return bricks_.size(); }
  [[nodiscard]] Coord coordOf(uint32_t brick) const { return bricks_[brick].coord; }
  [[nodiscard]] std::span<const AirLevel, kBrickVoxels> levelsOf(uint32_t brick) const { return bricks_[brick].level; }
  /// kNone where none stands there.
  [[nodiscard]] uint32_t brickAt(Coord coord) const;
  [[nodiscard]] Voxel voxel(Coord voxel) const;
  /// The room of a free voxel of a brick.
  [[nodiscard]] uint32_t roomAt(uint32_t brick, int at) const { return partOf(items_[itemOf_[brick]], at); }
  /// Voxels of a brick that are free and of rooms that are not the outside; `coord` where none has levels.
  [[nodiscard]] BrickMask closedIn(uint32_t brick, Coord coord);

  [[nodiscard]] uint32_t root(uint32_t room) { return sets_.find(room); }
  void join(uint32_t a, uint32_t b) { sets_.join(a, b); }

  /// Rooms that no way of free voxels leads out of, by their roots, in order.
  struct Room {
    uint32_t root;
    uint64_t voxels = 0;
    Coord first;  ///< One of its voxels.
  };
  [[nodiscard]] std::vector<Room> closedRooms();
  /// Bricks with voxels of such rooms or beside them, sorted.
  [[nodiscard]] std::vector<uint32_t> bricksOfClosedRooms();

 private:
  struct Levels {
    Coord coord;
    std::array<AirLevel, kBrickVoxels> level;
  };
  // A brick with levels, or bricks without from..to − 1 of a row along z that are all free, or all clay.
  struct Item {
    int32_t from, to;
    uint32_t brick;               // kNone: a gap
    uint32_t first = 0, end = 0;  // its parts in parts_
  };
  struct Part {
    uint32_t item;
    BrickMask mask;  // of a brick
  };
  struct Row {
    int32_t x, y;
    uint32_t first, end;  // of items_
  };

  void measure(const Version& version, double radius, int threads, const WorkPart& part);
  void makeRows(const Version& version);
  void joinAlong(const Row& row);
  void joinBeside(const Row& row, const Row* next, int axis, bool up);
  [[nodiscard]] const Row* rowAt(int32_t x, int32_t y) const;
  [[nodiscard]] const Item* itemAt(Coord coord) const;
  [[nodiscard]] uint32_t partOf(const Item& item, int at) const;

  std::vector<Levels> bricks_;
  std::unordered_map<Coord, uint32_t, CoordHash> at_;
  std::vector<Row> rows_;
  std::vector<Item> items_;
  std::vector<uint32_t> itemOf_;  // of a brick
  std::vector<Part> parts_;       // the first is the outside
  JoinedSets sets_{0};
};

}  // namespace argil::clay
