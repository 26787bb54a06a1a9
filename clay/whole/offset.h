#pragma once
// Clay that is thicker, thinner or hollow.

#include "clay/base/job.h"
#include "clay/base/work_part.h"
#include "clay/store/version.h"

namespace argil::clay {

struct ThinParts;  // clay/field/thin_parts.h

/// The surface moved by `mm` along its normals, outwards where positive: all points nearer than that to the solid
/// (outward corners get round), or what is left when all nearer than −mm to the outside are taken away. Any distance to
/// 10 000 voxels, in steps of at most 16 voxels; the error grows by about 0.01 voxel a step. Channels are those of the
/// nearest place of the surface; a shell's inner wall has them too. The result has a store of its own. `threads`: 0 for
/// all cores; it does not change the result. Throws Error for a distance out of range and when nothing is left,
/// Cancelled. Cost follows surface times distance.
/// What comes out thinner than kThinnest goes and is added to `gone`.
[[nodiscard]] Version offset(const Version& version, double mm, int threads = 0, Job* job = nullptr,
                             ThinParts* gone = nullptr);
[[nodiscard]] Version offset(const Version& version, double mm, int threads, const WorkPart& part,
                             ThinParts* gone = nullptr);

/// A wall around the surface, `innerMm` to its inside and `outerMm` to its outside; what is farther inside becomes
/// hollow. A part that is thinner than twice the inner wall stays solid, and so does what would be a hollow narrower
/// than `narrowMm`: hollows are what a ball of that width reaches, so their corners are as round as it. The wall must
/// be at least two voxels thick. As offset(), of which it takes four with narrow hollows, else two.
[[nodiscard]] Version shell(const Version& version, double innerMm, double outerMm, int threads = 0, Job* job = nullptr,
                            double narrowMm = 0, ThinParts* gone = nullptr);

}  // namespace argil::clay
