// Voxels of the air are flooded from rooms that nothing leaves, the widest first, until the outside is met.

#include "clay/field/necks.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <utility>

#include "clay/base/error.h"
#include "clay/field/air_rooms.h"
#include "clay/field/neck_width.h"

namespace argil::clay {

namespace {

constexpr double kNoNeck = 0.25;    // voxels below the radius: what is wider is none
constexpr uint64_t kLeastRoom = 8;  // voxels
constexpr size_t kStepEvery = 1 << 16;

class Flood {
 public:
  Flood(const Version& version, AirRooms& air, double radius, const WorkPart& part)
      : version_(version),
        air_(air),
        radius_(radius),
        part_(part),
        labels_(air.bricks()),
        beside_(air.bricks(), {kUnknown}) {}

  std::vector<Neck> run() {
    for (const AirRooms::Room& room : air_.closedRooms()) hollows_.emplace(room.root, Hollow{room.voxels, room.first});
    for (const uint32_t brick : air_.bricksOfClosedRooms()) begin(brick);
    for (level_ = kFree - 1; level_ > 0; --level_) {
      for (size_t i = 0; i < waiting_[level_].size(); ++i) {
        if (i % kStepEvery == 0) step();
        flood(waiting_[level_][i]);  // what it adds is of lower levels
      }
      waiting_[level_] = {};
    }
    std::stable_sort(necks_.begin(), necks_.end(),
                     [](const Neck& a, const Neck& b) { return a.radiusMm < b.radiusMm; });
    return std::move(necks_);
  }

 private:
  struct Place {
    uint32_t brick;
    int16_t at;
  };
  struct Hollow {
    uint64_t voxels;
    Coord first;
  };

  void step() const { part_.step(1 - double(level_) / kFree); }
  [[nodiscard]] static Coord inBrick(int at) { return {at >> 6, (at >> 3) & 7, at & 7}; }
  [[nodiscard]] Coord coordOf(const Place& place) const {
    return air_.coordOf(place.brick) * kBrickEdge + inBrick(place.at);
  }
  uint32_t& label(uint32_t brick, int at) {
    auto& labels = labels_[brick];
    if (!labels) {
      labels = std::make_unique<std::array<uint32_t, kBrickVoxels>>();
      labels->fill(AirRooms::kNone);
    }
    return (*labels)[static_cast<size_t>(at)];
  }

  // Bricks across the faces of one: −x, +x, −y, +y, −z, +z.
  const std::array<uint32_t, 6>& beside(uint32_t brick) {
    std::array<uint32_t, 6>& all = beside_[brick];
    if (all[0] == kUnknown)
      for (size_t side = 0; side < 6; ++side) all[side] = air_.brickAt(air_.coordOf(brick) + kSides[side]);
    return all;
  }

  // Calls back with each voxel that shares a face: its brick (AirRooms::kNone where it has no levels), its offset, the
  // side of its brick that it lies across.
  template <class Visit>
  void forEachBeside(const Place& place, const Visit& visit) {
    const Coord in = inBrick(place.at);
    const int c[3] = {in.x, in.y, in.z};
    for (size_t axis = 0; axis < 3; ++axis) {
      const int shift = 64 >> (3 * axis);
      for (const int up : {0, 1}) {
        const size_t side = 2 * axis + static_cast<size_t>(up);
        if (c[axis] != up * (kBrickEdge - 1))
          visit(place.brick, place.at + (2 * up - 1) * shift, side);
        else
          visit(beside(place.brick)[side], place.at - (2 * up - 1) * (kBrickEdge - 1) * shift, side);
      }
    }
  }
  [[nodiscard]] uint32_t roomAt(const Place& from, uint32_t brick, int at, size_t side) const {
    return brick != AirRooms::kNone ? air_.roomAt(brick, at) : air_.voxel(coordOf(from) + kSides[side]).room;
  }

  // Voxels of a brick that are not free themselves, beside hollows.
  void begin(uint32_t brick) {
    const auto levels = air_.levelsOf(brick);
    std::array<BrickMask, 7> closed;  // of the brick, then of those across its sides
    closed[6] = air_.closedIn(brick, {});
    for (size_t side = 0; side < 6; ++side)
      closed[side] = air_.closedIn(beside(brick)[side], air_.coordOf(brick) + kSides[side]);
    for (int v = 0; v < kBrickVoxels; ++v) {
      const AirLevel level = levels[static_cast<size_t>(v)];
      if (level == 0 || level == kFree) continue;
      const Place place{brick, static_cast<int16_t>(v)};
      forEachBeside(place, [&](uint32_t other, int at, size_t side) {
        if (!holds(closed[other == brick ? 6 : side], at) || label(brick, v) != AirRooms::kNone) return;
        label(brick, v) = roomAt(place, other, at, side);
        waiting_[level].push_back(place);
      });
    }
  }

  // What is at least as wide as `from` and can be reached from it, at once; what is narrower waits.
  void flood(const Place& from) {
    const uint32_t room = label(from.brick, from.at);
    if (air_.root(room) == 0) return;
    behind_.clear();
    rising_.assign(1, from);
    bool out = false;
    while (!rising_.empty() && !out) {
      const Place place = rising_.back();
      rising_.pop_back();
      forEachBeside(place, [&](uint32_t brick, int at, size_t side) {
        if (out) return;
        const AirLevel level = brick != AirRooms::kNone ? air_.levelsOf(brick)[static_cast<size_t>(at)] : kFree;
        if (level == 0) return;
        if (level == kFree) {
          const uint32_t there = roomAt(place, brick, at, side);
          if (there != AirRooms::kNone) out = meet(room, there, from);
          return;
        }
        uint32_t& other = label(brick, at);
        if (other != AirRooms::kNone) {
          // What waits is met when its turn comes.
          if (level >= level_) out = meet(room, other, from);
          return;
        }
        other = room;
        const Place next{brick, static_cast<int16_t>(at)};
        if (level < level_) {
          waiting_[level].push_back(next);
        } else {
          behind_.push_back(next);
          rising_.push_back(next);
        }
      });
    }
  }

  // True where the first of them is outside from now on.
  bool meet(uint32_t mine, uint32_t other, const Place& at) {
    const uint32_t a = air_.root(mine), b = air_.root(other);
    if (a == b) return a == 0;
    if (a != 0 && b != 0) {
      Hollow& one = hollows_.at(std::min(a, b));
      Hollow& two = hollows_.at(std::max(a, b));
      if (two.voxels > one.voxels) one.first = two.first;
      one.voxels += two.voxels;
      air_.join(a, b);
      return false;
    }
    opens(hollows_.at(std::max(a, b)), std::max(a, b), coordOf(at));
    air_.join(a, b);
    return a != 0;
  }

  // The hollow's way out is narrowest at a voxel.
  void opens(const Hollow& hollow, uint32_t root, Coord at) {
    if (hollow.voxels < kLeastRoom) return;
    step();
    std::vector<Coord> behind;
    for (const Place& each : behind_) behind.push_back(coordOf(each));
    std::sort(behind.begin(), behind.end());
    NeckBox box{.middle = at, .distance = {}, .end = {}};
    for (int x = -NeckBox::kReach; x <= NeckBox::kReach; ++x)
      for (int y = -NeckBox::kReach; y <= NeckBox::kReach; ++y)
        for (int z = -NeckBox::kReach; z <= NeckBox::kReach; ++z) {
          const Coord voxel = at + Coord{x, y, z};
          const size_t number = NeckBox::number({x, y, z});
          const AirRooms::Voxel found = air_.voxel(voxel);
          box.distance[number] = found.level == kFree ? INFINITY : float(found.level) / kFree * float(radius_);
          if (found.level < level_) continue;
          // All that is as wide and belongs to the hollow was taken before this voxel's turn came.
          const uint32_t room = found.level == kFree ? found.room : label(found.brick, found.at);
          const bool mine = room != AirRooms::kNone && air_.root(room) == root &&
                            !std::binary_search(behind.begin(), behind.end(), voxel);
          box.end[number] = mine ? NeckBox::End::one : NeckBox::End::other;
        }
    const NeckWidth width = neckWidth(version_, box);
    if (width.radius > radius_ - kNoNeck) return;
    const Grid& grid = version_.grid();
    necks_.push_back({grid.toWorld(hollow.first.toVec3d()), grid.toWorld(width.at), width.radius * grid.voxelMm});
  }

  const Version& version_;
  AirRooms& air_;
  double radius_;
  const WorkPart& part_;
  static constexpr uint32_t kUnknown = AirRooms::kNone - 1;
  static constexpr std::array<Coord, 6> kSides{{{-1, 0, 0}, {1, 0, 0}, {0, -1, 0}, {0, 1, 0}, {0, 0, -1}, {0, 0, 1}}};

  std::vector<std::unique_ptr<std::array<uint32_t, kBrickVoxels>>> labels_;  // rooms, of bricks that were reached
  std::vector<std::array<uint32_t, 6>> beside_;
  std::map<uint32_t, Hollow> hollows_;             // by root
  std::array<std::vector<Place>, kFree> waiting_;  // by level
  std::vector<Place> rising_, behind_;
  int level_ = 0;
  std::vector<Neck> necks_;
};

}  // namespace

std::vector<Neck> narrowNecks(const Version& version, double radiusMm, int threads, const WorkPart& part) {
  if (!(radiusMm > 0 && std::isfinite(radiusMm))) throw Error("necks: give a radius above 0 mm");
  const double radius = radiusMm / version.grid().voxelMm;
  if (radius < kLeastNeckVoxels) return {};
  AirRooms air(version, radius, threads, part.part(0, 0.8));
  const WorkPart rest = part.part(0.8, 1);
  return Flood(version, air, radius, rest).run();
}

}  // namespace argil::clay
