#pragma once
// Models of the test data as clay.

#include <filesystem>
#include <optional>

#include "bench/bench.h"
#include "clay/store/version.h"

namespace argil::bench {

/// Clay of a file's mesh, 100 mm long, with voxels of 0.25 mm. None, and a line in the report that says why, for one
/// that cannot be read or is not closed. Throws Cancelled.
std::optional<clay::Version> closedModel(BenchReport& report, const BenchOptions& options,
                                         const std::filesystem::path& file);

}  // namespace argil::bench
