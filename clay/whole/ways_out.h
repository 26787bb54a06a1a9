#pragma once
// Hollows that open too narrowly, of clay of any fineness.

#include <vector>

#include "clay/base/work_part.h"
#include "clay/field/necks.h"
#include "clay/store/version.h"

namespace argil::clay {

/// Radii beyond these are looked for in clay that is resampled, since what they cost is their cube: to voxels of which
/// the radius has kResampledNeckVoxels. Radii are within half of such a voxel then, and walls thinner than one are
/// open.
inline constexpr double kMostNeckVoxels = 24, kResampledNeckVoxels = 16;

/// As narrowNecks(), for any radius. `threads`: 0 for all cores.
[[nodiscard]] std::vector<Neck> narrowWaysOut(const Version& version, double radiusMm, int threads,
                                              const WorkPart& part);

}  // namespace argil::clay
