#pragma once
// How long files of quads and of smooth faces take, said before they are asked for.

#include <cstddef>
#include <string>

#include "engine/document/machine_speed.h"
#include "engine/models/model_files.h"

namespace argil::engine {

/// Between these, by the shape: folds and thin places take longer. 0 where nothing takes long.
struct ExportTime {
  double leastS = 0, mostS = 0;
};

/// Adds up the time for `pieces` pieces of ordinary clay. `quads`: some file holds quads, else ModelExport::quads does
/// not count; `cad`: some file is a smooth solid.
[[nodiscard]] ExportTime exportTime(const ModelExport& what, size_t pieces, bool quads, bool cad,
                                    const MachineSpeed& machine);

/// Returns "20 s to 2 min, by the shape"; empty below a second.
[[nodiscard]] std::string sentence(const ExportTime& time);

}  // namespace argil::engine
