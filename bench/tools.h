#pragma once
// A part of `argil bench edit`.

#include <vector>

#include "clay/base/job.h"

namespace argil::bench {

class BenchReport;

/// What a stamp of each tool of the table costs, on models of so many million active voxels.
void benchTools(BenchReport& report, const std::vector<double>& sizes, Job* job);

}  // namespace argil::bench
