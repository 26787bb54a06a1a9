#pragma once
// argil bench io: the rows of 3MF.

#include <filesystem>

#include "bench/bench.h"
#include "io/models/model_writer.h"

namespace argil::bench {

/// Writes the model (one object) into `folder` and reads it again, beside lib3mf writing the same mesh: by the program
/// bench-lib3mf in the folder of this one, if it is there. The files are removed. Throws Error, Cancelled.
void benchThreeMf(BenchReport& report, const io::ModelView& model, const std::filesystem::path& folder, int runs,
                  Job* job = nullptr);

}  // namespace argil::bench
