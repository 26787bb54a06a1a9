#pragma once
// What reduce() asks of the measure of deviation beside its result.

#include <cstdint>
#include <vector>

#include "clay/base/work_part.h"
#include "clay/mesh/reduce.h"

namespace argil::clay {

/// As deviation(). `beyond`: gets the vertices of `original` next to points that are farther off than `limitMm`, some
/// of them several times.
[[nodiscard]] Deviation measureDeviation(const TriangleMesh& original, const TriangleMesh& other, double limitMm,
                                         std::vector<uint32_t>& beyond, const WorkPart& work);

}  // namespace argil::clay
