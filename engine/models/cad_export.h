#pragma once
// Pieces as smooth solids for CAD.

#include <filesystem>
#include <string>
#include <vector>

#include "engine/models/model_files.h"

namespace argil::engine {

/// Faces of a piece that are tried at most where an error is asked for and no count.
inline constexpr size_t kMostFacesWithin = 4000;

/// The pieces that count as a STEP or IGES file, whole or not at all; `what.cadQuads` faces at most a piece, or as few
/// as keep within `what.cadErrorMm`. Sentences for the person: what was written, how far each lies off its clay both
/// ways, and whether its cage kept the clay's shape. Throws Error, Cancelled.
[[nodiscard]] std::vector<std::string> writeCad(const std::filesystem::path& file, const Document& document,
                                                const ModelExport& what, Job* job = nullptr);

}  // namespace argil::engine
