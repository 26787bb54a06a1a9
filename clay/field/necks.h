#pragma once
// Hollows that open to the outside by less than what must pass there: resin, powder, a cleaning rod.

#include <vector>

#include "clay/base/work_part.h"
#include "clay/store/version.h"

namespace argil::clay {

/// A hollow with room for a ball that cannot leave it.
struct Neck {
  Vec3d hollowMm = Vec3d::Zero();  ///< A place in the hollow where the ball has room, mm in the piece.
  Vec3d atMm = Vec3d::Zero();      ///< The narrowest place of the widest way out.
  double radiusMm = 0;             ///< Of the largest ball that leaves.
};

/// Radii that are looked for are at least so many voxels; below, a grid does not tell.
inline constexpr double kLeastNeckVoxels = 1.5;

/// The hollows that a ball of `radiusMm` fits into and cannot leave, the narrowest neck first. Hollows without any way
/// out are not among them (sweepSlices() has them). A way that is narrower than the ball by less than a quarter of a
/// voxel is no neck. Two hollows whose ways out share their narrowest place are one. Radii are within half a voxel of
/// the surface's own. Empty for a radius below kLeastNeckVoxels. The result does not depend on `threads`. Throws
/// Cancelled; Error for a radius that is no number above zero. Cost: distances of the air up to the radius, some 30 ns
/// a voxel and thread; where there are hollows, the air around them up to where they open. Memory: a byte a voxel of
/// that air. Method: NOTES.md, "Necks".
[[nodiscard]] std::vector<Neck> narrowNecks(const Version& version, double radiusMm, int threads, const WorkPart& part);

}  // namespace argil::clay
