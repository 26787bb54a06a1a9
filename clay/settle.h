#pragma once
// What an operation on a whole piece ends with: distances again, and channels in the band alone.

#include <span>

#include "clay/editor.h"
#include "clay/job.h"

namespace argil::clay {

/// As redistance(), for any number of bricks (sorted, each once), region by region, so that memory does not grow with them. Reports the job's fraction from `jobFrom`
/// to 1. One thread; 4 µs a brick.
void redistanceByRegion(Editor& editor, std::span<const Coord> bricks, Job* job = nullptr, double jobFrom = 0);

/// Channels count in the band alone: makes the bytes of all other voxels of a brick coordinate 0.
void clearChannelsOutsideBand(Editor& editor, Coord brick);

/// Gives `editor` what `from` has in its channels wherever both are in the band, and 0 elsewhere; for an operation that took clay away. In another store than that of
/// `from`, or on `from` itself. Nothing where there are no channels; else O(bricks).
void keepChannels(Editor& editor, const Version& from);

}  // namespace argil::clay
