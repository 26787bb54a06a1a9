#pragma once
// What whole-piece operations share: regions of 64³ voxels, worked on side by side, written one after the other.

#include <functional>
#include <span>
#include <vector>

#include "clay/base/work_part.h"
#include "clay/field/distance_box.h"
#include "clay/store/editor.h"

namespace argil::clay {

struct ThinParts;  // clay/field/thin_parts.h

inline constexpr int kRegionBricks = 8;
inline constexpr int kRegionVoxels = kRegionBricks * kBrickEdge;

/// Throws Error but for 0 (all cores) to 64; the count of threads.
[[nodiscard]] int threadCount(int threads);

/// Regions (brick coordinate / 8) that lie within `reach` voxels of a brick, in order. `first`: only for bricks that it
/// wants; null: all.
[[nodiscard]] std::vector<Coord> regionsNear(const Version& version, int reach,
                                             const std::function<bool(const Brick&)>& wants = nullptr);

/// Makes inside of `target`, which is all outside, what is an inside tile of `version`: same coordinates.
void copyTiles(const Version& version, Editor& target);

/// Writes all of `version` into `target`, which is all outside: tiles, distances and channels, at the same coordinates
/// and in voxels, as fine as the target's store keeps them.
void copyAll(const Version& version, Editor& target, const WorkPart& part);

/// A version of the same grid in a store of its own: each voxel of `regions` has the distance of a box that was filled
/// there with `reach`, less `shift`; elsewhere there are the tiles of `source`. The reach covers the shifted band.
/// Channels come along from the nearest place of the old surface. What is thinner than kThinnest goes and is added to
/// `gone`. The result depends on neither threads nor order.
[[nodiscard]] Version rebuild(const Version& source, std::span<const Coord> regions, DistanceBox::Reach reach,
                              int threads, const WorkPart& part, float shift, ThinParts* gone = nullptr);

/// In voxels³, if the surface lay `shift` voxels farther out, less than the band: a voxel counts with 1/2 − phi,
/// between 0 and 1, which is right on average for a plane of any direction. The result does not depend on `threads`.
[[nodiscard]] double volumeOf(const Version& version, float shift = 0, int threads = 1);
/// In voxels²: crossed voxel edges, 1.5 for each of a plane, mean over directions.
[[nodiscard]] double areaOf(const Version& version);

/// The value that `brick` has everywhere as one of the tiles: a distance of ±band.
[[nodiscard]] inline float tileValue(Tile tile, float band) {
  return tile == Tile::inside ? -band : band;
}

}  // namespace argil::clay
