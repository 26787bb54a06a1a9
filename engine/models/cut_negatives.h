#pragma once
// What slicers cut away from a model is cut from its clay.

#include <string>
#include <vector>

#include "clay/base/job.h"
#include "clay/store/version.h"
#include "io/models/model_file.h"

namespace argil::engine {

/// The clay of objects of one assembly without the negative volumes of the same, in mm; a note says what became of
/// each. Throws Cancelled.
[[nodiscard]] clay::Version withoutNegatives(clay::Version version, uint32_t assembly,
                                             const std::vector<io::ModelObject>& negatives,
                                             std::vector<std::string>& notes, Job* job);

}  // namespace argil::engine
