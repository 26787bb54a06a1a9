#pragma once
// Checks of a print and what prepares one, beside the programs that people use for it today.

#include "bench/bench.h"

namespace argil::bench {

/// A koala, which is solid all over, and fandisk, which is all edges: walls beside the 3D-Print Toolbox of Blender,
/// hollowing and laying on a bed beside PrusaSlicer. Says what it leaves out for want of models or of a program.
void benchPrintPeers(BenchReport& report, const BenchOptions& options);

}  // namespace argil::bench
