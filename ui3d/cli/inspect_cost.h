#pragma once
// What clay will cost, and what a document costs: parts of `argil inspect`.

#include <nlohmann/json.hpp>
#include <optional>
#include <vector>

#include "clay/mesh/triangle_mesh.h"
#include "clay/surface/surface.h"
#include "engine/document/document.h"

namespace argil::cli {

/// Of a mesh as clay, by preset and for this voxel size: no clay is made. `say`: as a table too.
nlohmann::ordered_json planCosts(const clay::TriangleMesh& mesh, const std::optional<double>& voxelMm, bool say);

/// Of the process as it is, its memory item by item, beside what the system counts. `surfaces`: those of the document
/// that are held.
nlohmann::ordered_json memoryCosts(const engine::Document& document, const std::vector<clay::Surface>& surfaces,
                                   bool say);

}  // namespace argil::cli
