#pragma once
// Clay that follows a map of space: lattice, bend, twist, taper.

#include <memory>

#include "clay/job.h"
#include "clay/version.h"
#include "clay/warp.h"

namespace argil::clay {

inline constexpr double kMostStretch = 8;  ///< How much a warp may stretch or press the clay in any direction.

/// The box of a version's bricks, mm: a band and up to a brick larger than the solid. Empty clay: low above high. O(bricks).
[[nodiscard]] BoxMm boundsOf(const Version& version);

/// The clay as the warp moves it: closed, with a proper narrow band, on the same grid. Where parts of it come to lie over each other they are united. The version is
/// in `store` (it may be the same or another) and shares nothing with `version`. Distances are taken from the nearest place of the warped surface, to second order;
/// on smooth surfaces within 0.05 voxel RMS. Method and figures: NOTES.md, "Deformation".
/// Throws Error when the map folds (its determinant is not positive somewhere in its domain), stretches or presses by more than kMostStretch, or when the result is
/// out of reach; Cancelled. The result does not depend on `threads` (0: all cores). Cost: about 1.5 µs a voxel of the band; the job's fraction grows evenly.
[[nodiscard]] Version deform(const Version& version, const Warp& warp, std::shared_ptr<Store> store, Job* job = nullptr, int threads = 0);

/// Throws the Error that deform() would throw for this map over clay that fills `piece`. Milliseconds: for faces that want to say so at once.
void requireUnfolded(const Warp& warp, const BoxMm& piece);

}  // namespace argil::clay
