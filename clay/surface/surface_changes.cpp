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

// Bit dx·4 + dy·2 + dz: the bricks differ in a voxel that cells of the brick dx, dy, dz lower have as a corner.
unsigned changedFor(Slot before, Slot after) {
  if (before.isTile() || after.isTile()) return 0xff;
  uint64_t d[8];
  BrickValues was, is;
  differingVoxels(before.brick()->values(was), after.brick()->values(is), d);
  const uint64_t all = d[0] | d[1] | d[2] | d[3] | d[4] | d[5] | d[6] | d[7];
  const auto bits = [](uint64_t word) {
    return unsigned{word != 0} | unsigned{(word & kLowZ) != 0} << 1 | unsigned{(word & 0xff) != 0} << 2 |
           unsigned{(word & 1) != 0} << 3;
  };
  return bits(all) | bits(d[0]) << 4;
}

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
    for (unsigned left = changedFor(before, after); left != 0; left &= left - 1)
      changes[static_cast<size_t>(std::countr_zero(left))][static_cast<size_t>(brick.x & 7)] |=
          RegionTasks::bitOf(brick);
    if (bricksThatReadBeyond == 0) return;
    for (const Coord step : kAroundSteps) {
      // Folded faces of lower bricks look at layers that changedFor() has told of.
      if (grade == Grade::draft && step.x <= 0 && step.y <= 0 && step.z <= 0) continue;
      const HeldMesh* held = find(brick + step);
      if (held && held->table.readsBeyond) tasks.want(brick + step);
    }
  });
  flush();
  return tasks;
}

}  // namespace argil::clay
