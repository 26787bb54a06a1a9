#pragma once
// The same voxels of another size.

#include "clay/base/work_part.h"
#include "clay/store/version.h"

namespace argil::clay {

/// `version` with voxels `factor` times as large, in a store of its own: every distance keeps its bits, as distances
/// are in voxels, so the shape is exactly the same one, scaled about the zero of its millimetres. Throws Error for
/// voxels or an origin out of range, Cancelled. Cost O(model).
[[nodiscard]] Version scaled(const Version& version, double factor, const WorkPart& part = WorkPart(nullptr));

}  // namespace argil::clay
