#pragma once
// Clay that follows a map of space: lattice, bend, twist, taper.

#include <memory>

#include "clay/base/job.h"
#include "clay/store/version.h"
#include "clay/whole/warp.h"

namespace argil::clay {

inline constexpr double kMostStretch = 8;  ///< How much a warp may stretch or press the clay in any direction.

/// The solid's box, mm: holds its surface, and no side is more than a voxel off. Empty clay: low above high. O(bricks).
[[nodiscard]] BoxMm boundsOf(const Version& version);
/// The box of its bricks: holds the band too, and is up to a brick larger than it.
[[nodiscard]] BoxMm brickBoundsOf(const Version& version);

/// The clay as the warp moves it: closed, with a proper narrow band, on the same grid. Where parts of it come to lie
/// over each other they are united. The version is in `store` (it may be the same or another) and shares nothing with
/// `version`. Distances are taken from the nearest place of the warped surface, to second order; on smooth surfaces
/// within 0.05 voxel RMS. Method and figures: deformation.md. Throws Error when the map folds (its determinant
/// is not positive somewhere in its domain), stretches or presses by more than kMostStretch, or when the result is out
/// of reach; Cancelled. The result does not depend on `threads` (0: all cores). Cost: about 1.5 µs a voxel of the band;
/// the job's fraction grows evenly.
[[nodiscard]] Version deform(const Version& version, const Warp& warp, std::shared_ptr<Store> store, Job* job = nullptr,
                             int threads = 0);

}  // namespace argil::clay
