#pragma once
// A mesh file on its way to clay, as several verbs need it.

#include <filesystem>
#include <optional>

#include "clay/import/mesh_to_clay.h"
#include "engine/models/import_place.h"
#include "io/models/mesh_file.h"

namespace argil::cli {

/// Reads a mesh, in mm: `units` are those of a file that names none.
[[nodiscard]] io::MeshFile readMeshIn(const std::filesystem::path& file, const std::string& units, Job* job);

/// The same, placed as wished. Says so in the notes where something was guessed, turned or scaled.
[[nodiscard]] io::MeshFile readMeshIn(const std::filesystem::path& file, const engine::ImportPlace& wish, Job* job);

/// Throws Error for a file that holds clay when anything but its units was wished for: clay has its size and place.
void requireModel(const std::filesystem::path& file, const engine::ImportPlace& wish);

/// Makes the mesh of a file clay, with `voxelMm` or 256 voxels along its longest side; with `tell` prints what was
/// repaired. What is wrong is told with the file's name.
[[nodiscard]] clay::Imported meshAsClay(const std::filesystem::path& file, const clay::TriangleMesh& mesh,
                                        std::optional<double> voxelMm, Job* job, bool tell = true);

}  // namespace argil::cli
