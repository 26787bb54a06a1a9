#pragma once
// Triangle meshes from files: what a model is when only its triangles matter.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "clay/base/job.h"
#include "clay/mesh/triangle_mesh.h"
#include "io/models/model_file.h"

namespace argil::io {

/// What a file held, as one mesh. Positions are in the file's own units, nothing is scaled here. All
/// coordinates are finite, all indices in range, and there is at least one triangle; nothing is promised about
/// topology.
struct MeshFile {
  clay::TriangleMesh mesh;
  std::optional<double> unitMm;         ///< As ModelFile has it.
  std::vector<Colour> vertexColours;    ///< One a vertex, or empty.
  std::vector<Colour> triangleColours;  ///< One a triangle, or empty.
  std::optional<Colour> colour;         ///< Mean of them, or what the file says of the whole.
  /// "STL (binary)", "STL (text)", "OBJ", "PLY (text)", "PLY (binary)", "OFF", as ModelFile has it.
  std::string format;
  uint64_t faces = 0;     ///< As the file has them, before polygons became triangles.
  uint64_t polygons = 0;  ///< Faces of more than three corners, divided by ear clipping where no fan covers them.
  bool welded = false;    ///< Vertices of equal coordinates were made one (STL repeats them in every triangle).
  std::vector<std::string> notes;  ///< What was there and is not kept, a sentence each, for the person.
};

/// Reads a model of any format and makes its objects one mesh; the content says which format it is, the ending of the
/// name only where the content does not. Throws Error, one line that names the file, what is wrong, the line or byte,
/// and what to do: for what cannot be opened, is no regular file, is empty, is cut off, has numbers that are not
/// finite, indices out of range or no triangle. Counts that a file claims are checked against its length before memory
/// is taken for them. Throws Cancelled. Any thread.
[[nodiscard]] MeshFile readMesh(const std::filesystem::path& path, Job* job = nullptr);

/// The same from memory, for formats that this program reads itself; `name` stands for the path in messages and gives
/// the ending.
[[nodiscard]] MeshFile parseMesh(std::span<const std::byte> bytes, const std::string& name, Job* job = nullptr);

}  // namespace argil::io
