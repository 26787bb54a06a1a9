#pragma once
// The second half of `argil bench costs`.

#include "bench/bench.h"
#include "engine/document/machine_speed.h"

namespace argil::bench {

/// Three random uses of each operation on whole pieces: processor time and bytes, said over is. Rows that are off by
/// more than a quarter, and how far all are.
void benchPieceCosts(BenchReport& report, const BenchOptions& options, const engine::MachineSpeed& machine);

}  // namespace argil::bench
