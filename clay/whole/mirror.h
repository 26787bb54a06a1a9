#pragma once
// One half of a clay in the place of the other.

#include "clay/base/job.h"
#include "clay/store/version.h"

namespace argil::clay {

/// What lies where `normal` points to (mm, any length but zero) from a plane through `pointMm`, and its mirror image in
/// the place of what lay on the other side. Bit-equal halves where the plane is normal to an axis and halfway between
/// voxels or on them; bricks mirror bricks where it lies at voxel 8k − 1/2 of the axis. Channels come along. Any other
/// plane: read by cubic splines. Distances near the plane are made anew where what they were measured to is gone. The
/// result is made from `version`, in its store, beside whoever edits there. `threads`: 0 for all cores; it does not
/// change the result. Throws Error for a normal without length, a plane that is not finite and when nothing is left,
/// Cancelled. Cost follows the surface.
[[nodiscard]] Version mirrorHalf(const Version& version, const Vec3d& pointMm, const Vec3d& normal, int threads = 0,
                                 Job* job = nullptr);

}  // namespace argil::clay
