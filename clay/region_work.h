#pragma once
// What whole-piece operations share: regions of 64³ voxels, worked on side by side, written one after the other.

#include <functional>
#include <span>
#include <vector>

#include "clay/distance_box.h"
#include "clay/editor.h"
#include "clay/work_part.h"

namespace argil::clay {

inline constexpr int kRegionBricks = 8;
inline constexpr int kRegionVoxels = kRegionBricks * kBrickEdge;

/// Throws Error but for 0 (all cores) to 64; the count of threads.
[[nodiscard]] int threadCount(int threads);

/// Regions (brick coordinate / 8) that lie within `reach` voxels of a brick, in order. `first`: only for bricks that it wants; null: all.
[[nodiscard]] std::vector<Coord> regionsNear(const Version& version, int reach, const std::function<bool(const Brick&)>& wants = nullptr);

/// Makes inside of `target`, which is all outside, what is an inside tile of `version`: same coordinates.
void copyTiles(const Version& version, Editor& target);

/// Calls work(item, box) for each item below `count` on so many threads, in no set order, each thread with a box of its own; tells `part`
/// how far it is after each item.
void forEachItem(size_t count, int threads, const WorkPart& part, const std::function<void(size_t, DistanceBox&)>& work);

/// A version of the same grid in a store of its own, whose distance at each voxel of `regions` is value(box, voxel) of a box that was filled
/// there with `reach`; elsewhere the tiles of `source`. The result depends on neither threads nor order.
[[nodiscard]] Version rebuild(const Version& source, std::span<const Coord> regions, DistanceBox::Reach reach, int threads, const WorkPart& part,
                              const std::function<float(const DistanceBox&, Coord)>& value);

/// The value that `brick` has everywhere as one of the tiles: a distance of ±band.
[[nodiscard]] inline float tileValue(Tile tile, float band) { return tile == Tile::inside ? -band : band; }

}  // namespace argil::clay
