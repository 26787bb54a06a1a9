#pragma once
// The same clay with distances of another precision.

#include "clay/base/work_part.h"
#include "clay/store/version.h"

namespace argil::clay {

/// All of `version`, its channels included, in a store of its own. To Precision::fixed16 each distance goes to the
/// nearest step of band / 32 767 (with the usual band of 3 it moves by 0.00005 voxel at most), and a voxel never
/// changes sides, so the surface keeps its topology; to Precision::float32 nothing changes. Of that precision already:
/// the version itself. Throws Cancelled; Error for a band that 16 bits cannot tell. Cost O(model).
[[nodiscard]] Version withPrecision(const Version& version, Precision precision,
                                    const WorkPart& part = WorkPart(nullptr));

}  // namespace argil::clay
