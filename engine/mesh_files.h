#pragma once
// Meshes come in from files and go out to them.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "clay/job.h"
#include "engine/document.h"

namespace argil::engine {

/// mm in one unit: mm, um, cm, m, in or ft. Throws Error for another name.
[[nodiscard]] double unitMm(const std::string& units);

struct MeshImport {
  std::string units = "mm";
  std::optional<double> voxelMm;   ///< None: 256 voxels along the longest side.
  std::optional<double> fitMm;     ///< Centred at zero and scaled until the longest side is this.
  bool asPart = false;             ///< Stays a mesh.
  /// Gets the mesh as soon as it is read, in mm, long before it is clay: to be shown meanwhile.
  std::function<void(std::shared_ptr<const clay::TriangleMesh>)> onRead = {};
};
struct ImportedThing {
  clay::Version version;           ///< Of a piece,
  std::optional<Part> part;        ///< or a part, ready to be felt.
  std::vector<std::string> notes;  ///< What was found and done, a sentence each.
};
/// Throws Error that names the file, Cancelled.
[[nodiscard]] ImportedThing importMesh(const std::filesystem::path& file, const MeshImport& how, Job* job = nullptr);

/// The surface of one piece (`piece` not 0), of all visible ones, or of all, as one mesh in world mm; each piece closed. Throws Error when there
/// is none, Cancelled.
[[nodiscard]] clay::TriangleMesh meshOf(const Document& document, Id piece, bool visibleOnly, Job* job = nullptr);

/// Writes a mesh by the ending of its name, whole or not at all; a sentence for the person. Throws Error, Cancelled.
std::string writeMeshFile(const std::filesystem::path& file, const clay::TriangleMesh& mesh, Job* job = nullptr);

}  // namespace argil::engine
