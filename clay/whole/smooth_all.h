#pragma once
// A whole clay evened out.

#include "clay/base/job.h"
#include "clay/store/version.h"

namespace argil::clay {

/// `passes` times (1 to 200) the binomial mean of 3×3×3 voxels over the field: bumps of a few voxels go. After every
/// four the field is made distances again: solved where it is bent, in the end all over (NOTES.md). With `keepVolume`
/// the surface then moves outwards evenly until the volume is as before. Channels stay in their places; what is new in
/// the band has those of the nearest surface. The result has a store of its own. `threads`: 0 for all cores; it does
/// not change the result. Throws Error for passes out of range and when nothing is left, Cancelled. Cost: surface times
/// passes.
[[nodiscard]] Version smoothAll(const Version& version, int passes, bool keepVolume, int threads = 0,
                                Job* job = nullptr);

}  // namespace argil::clay
