#pragma once
// A version with distances known farther out.

#include "clay/base/job.h"
#include "clay/store/version.h"

namespace argil::clay {

/// The same field with a band of `band` voxels (that of the version to 8), in a store of its own: what was known keeps
/// its bits, farther voxels are first order. Cost and memory follow the surface. Runs on TBB's threads.
[[nodiscard]] Version wideBand(const Version& version, float band, Job* job = nullptr);

}  // namespace argil::clay
