#pragma once
// A mesh file on its way to clay, as several verbs need it.

#include <filesystem>
#include <optional>

#include "clay/mesh_to_clay.h"
#include "io/mesh_file.h"

namespace argil::cli {

/// Reads a mesh, in mm.
[[nodiscard]] io::MeshFile readMeshIn(const std::filesystem::path& file, const std::string& units, Job* job);

/// Makes it clay, with `voxelMm` or 256 voxels along its longest side; prints what was repaired to stderr.
[[nodiscard]] clay::Imported meshAsClay(const clay::TriangleMesh& mesh, std::optional<double> voxelMm, Job* job);

}  // namespace argil::cli
