#pragma once
// What an operation on a whole piece ends with: distances again, and channels in the band alone.

#include <functional>
#include <span>
#include <vector>

#include "clay/base/job.h"
#include "clay/base/work_part.h"
#include "clay/field/redistance.h"
#include "clay/store/editor.h"

namespace argil::clay {

/// As redistance(), to the bit, for any number of bricks (each once), region by region: what it works with does not
/// grow with them, but for the bricks that change. Reports the job's fraction from `jobFrom` to 1. One thread; 6 µs a
/// brick.
void redistanceByRegion(Editor& editor, std::span<const Coord> bricks, Job* job = nullptr, double jobFrom = 0);

/// Voxels; what neighbours of a resampled field differ by at most. Splines of smooth fields stay below it.
inline constexpr float kSteepest = 1.05f;

/// Brings distances of `bricks` that are farther from the surface than a neighbour's plus kSteepest to that, and
/// shortens both ends of a voxel edge that the surface crosses where they are farther apart, by the same share; what
/// follows from that too. Voxels that come into the band have the channels of the one beside them that brought them
/// there. The result does not depend on `threads`. About 2 µs a brick.
void limitSlopes(Editor& editor, std::span<const Coord> bricks, int threads, const WorkPart& part);

/// Channels count in the band alone: makes the bytes of all other voxels of a brick coordinate 0.
void clearChannelsOutsideBand(Editor& editor, Coord brick);
/// The same where bricks are fixed: a distance just within the band may have been rounded to it after its channels were
/// found.
void clearChannelsRoundedAway(Editor& editor, Coord brick);

/// Gives `editor` what `from` has in its channels wherever both are in the band, and 0 elsewhere; for an operation that
/// took clay away. In another store than that of `from`, or on `from` itself. Nothing where there are no channels; else
/// O(bricks).
void keepChannels(Editor& editor, const Version& from);

/// Bricks of `coords` without a sign change in themselves or a neighbour become tiles: a band is no wider than a brick.
void dropWithoutSurface(Editor& editor, const std::vector<Coord>& coords);
/// Asked for a voxel whose old value, which is given, the solution exceeds by the tolerance: is it a distance to a
/// surface? Then it stays. From one thread.
using StandsTest = std::function<bool(Coord voxel, float old)>;
/// redistance() on one thread that keeps what stands.
std::vector<Coord> redistanceUnless(Editor& editor, std::span<const Coord> coords, float tolerance,
                                    const StandsTest& stands);
/// redistance() of any number of bricks, after those without a surface near became tiles, in an order of their own:
/// about 5 KB each at a time, twice where there are too many for one call.
void redistanceAll(Editor& editor, std::vector<Coord> coords, const WorkPart& part,
                   float tolerance = kRedistanceTolerance, const StandsTest& stands = nullptr);
/// Those of the bricks around `coords` (themselves among them) that the editor has, each once, sorted.
[[nodiscard]] std::vector<Coord> bricksAround(const Editor& editor, const std::vector<Coord>& coords);

}  // namespace argil::clay
