// Which bricks of a surface may be others in another version.

#include "clay/store/brick_set.h"
#include "clay/store/tree.h"
#include "clay/store/tree_view.h"
#include "clay/surface/surface_state.h"

namespace argil::clay {
namespace {

// Regions whose bricks can have a vertex.
void addRegions(Link link, int level, Coord first, RegionTasks& tasks) {
  if (isTile(link)) return;
  if (level == 1) {
    for (int k = 0; k < 8; ++k) tasks.at((first >> 3) - Coord{k >> 2, (k >> 1) & 1, k & 1});
    return;
  }
  const int step = 1 << (3 * (level - 1));
  for (int i = 0; i < 512; ++i)
    addRegions(reinterpret_cast<const Node*>(link)->child[i], level - 1,
               first + Coord{i >> 6, (i >> 3) & 7, i & 7} * step, tasks);
}

// The voxels in which two bricks differ: all, where one of them is a tile.
struct Differing {
  uint64_t d[8];
  Differing(Slot before, Slot after) {
    if (before.isTile() || after.isTile()) {
      std::fill_n(d, 8, ~uint64_t{0});
      return;
    }
    BrickValues was, is;
    differingVoxels(before.brick()->values(was), after.brick()->values(is), d);
  }

  // Bit dx·4 + dy·2 + dz: some are corners of cells of the brick dx, dy, dz lower.
  [[nodiscard]] unsigned forLower() const {
    const uint64_t all = d[0] | d[1] | d[2] | d[3] | d[4] | d[5] | d[6] | d[7];
    const auto bits = [](uint64_t word) {
      return unsigned{word != 0} | unsigned{(word & kLowZ) != 0} << 1 | unsigned{(word & 0xff) != 0} << 2 |
             unsigned{(word & 1) != 0} << 3;
    };
    return bits(all) | bits(d[0]) << 4;
  }

  // Bit i: some are no farther from the brick at kAroundSteps[i] than its vertices may look: four layers of a lower
  // brick, five of a higher one.
  [[nodiscard]] uint32_t around() const {
    constexpr uint64_t kAll = ~uint64_t{0};
    constexpr uint64_t kY[3] = {0xffffffffff, kAll, uint64_t{0xffffffff} << 32},
                       kZ[3] = {0x1f * kLowZ, kAll, 0xf0 * kLowZ};
    const uint64_t lower = d[0] | d[1] | d[2] | d[3] | d[4], upper = d[4] | d[5] | d[6] | d[7],
                   sides[3] = {lower, lower | upper, upper};
    uint32_t found = 0;
    for (size_t i = 0; i < kBricksAround; ++i) {
      const Coord step = kAroundSteps[i];
      const auto at = [](int32_t s) { return static_cast<size_t>(s + 1); };
      found |= uint32_t{(sides[at(step.x)] & kY[at(step.y)] & kZ[at(step.z)]) != 0} << i;
    }
    return found;
  }
};

}  // namespace

// Another model: all that stood is looked at again, together with all that stands.
RegionTasks Surface::State::allRegions(const Version& next) const {
  RegionTasks tasks;
  addRegions(next.record()->roots[kDistanceTree], kTreeLevels, treeFirst(), tasks);
  for (const auto& entry : regions) tasks.at(entry.first);
  return tasks;
}

// Bricks whose cells may have other vertices now: a cell reads its own brick and those one step higher; one with a
// folded face also reads the cell beyond, one with a kink all around; the fine grade reads around every brick.
RegionTasks Surface::State::changedRegions(const Version& next) const {
  RegionTasks tasks;
  // Of the region at hand, by how much lower: bricks with a change for those.
  Coord region{INT32_MIN, 0, 0};
  std::array<RegionBits, 8> changes{};
  // The region met last: those of neighbours are seldom others.
  Coord metAt{INT32_MIN, 0, 0};
  const SurfaceRegion* met = nullptr;
  const auto flush = [&] {
    for (int k = 0; k < 8; ++k) tasks.wantLower(region, k, changes[static_cast<size_t>(k)]);
    changes = {};
  };
  Version::forEachDifference(version, next, [&](Coord brick, Slot before, Slot after) {
    if (grade == Grade::fine) {
      for (const Coord step : kAroundSteps) tasks.want(brick + step);
      return;
    }
    if (brick >> 3 != region) {
      flush();
      region = brick >> 3;
    }
    const Differing differing(before, after);
    for (unsigned left = differing.forLower(); left != 0; left &= left - 1)
      changes[static_cast<size_t>(std::countr_zero(left))][static_cast<size_t>(brick.x & 7)] |=
          RegionTasks::bitOf(brick);
    if (bricksThatReadBeyond == 0) return;
    for (uint32_t left = differing.around(); left != 0; left &= left - 1) {
      const Coord step = kAroundSteps[static_cast<size_t>(std::countr_zero(left))];
      // Folded faces of lower bricks look at layers that forLower() has told of.
      if (grade == Grade::draft && step.x <= 0 && step.y <= 0 && step.z <= 0) continue;
      const Coord other = brick + step;
      if (other >> 3 != metAt) met = this->region(metAt = other >> 3);
      if (!met) continue;
      const HeldMesh* held = met->held[static_cast<size_t>(Brick::offset(other.x & 7, other.y & 7, other.z & 7))].get();
      if (held && held->table.readsBeyond) tasks.want(other);
    }
  });
  flush();
  return tasks;
}

}  // namespace argil::clay
