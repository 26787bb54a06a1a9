#pragma once
// The clay that a script begins with.

#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clay/base/job.h"
#include "engine/text/script.h"

namespace argil::engine {

struct PreparedClay {
  clay::Version version;           ///< What the strokes begin on; none for a script that begins with a new piece.
  Document document;               ///< The piece "Clay" of it; of a saved document all that it holds.
  std::vector<std::string> notes;  ///< Sentences for the person: what was repaired, scaled, chosen.
};

struct PrepareOptions {
  /// A mesh or a saved document that takes the place of the script's own clay; empty: none.
  std::filesystem::path input = {};
  std::optional<double> voxelMm = {};  ///< Goes before the script's; of the clay that the strokes begin on.
  Job* job = nullptr;
};

/// Makes a script's clay. Without a voxel size a mesh gets as many voxels along
/// its longest side as its quality says, 256 without one, and so does a shape of a script with a quality; else 0.5 mm.
/// Throws Error when there is no clay to begin with or the mesh cannot be read or made clay; Cancelled.
[[nodiscard]] PreparedClay prepareClay(std::shared_ptr<clay::Store> store, const Script& script,
                                       const PrepareOptions& options = {});

}  // namespace argil::engine
