#pragma once
// Triangle meshes from files: what a model is when only its triangles matter.

#include <array>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <utility>
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

/// Collects the faces of one file. Each has its place among the triangles, two fewer than it has corners, from the
/// beginning, so that colours and objects can name them before their shape is known.
class PolygonList {
 public:
  static constexpr uint32_t kNone = UINT32_MAX;

  /// Adds a face to the file's triangles, as a fan about its first corner, and counts it. At least three corners.
  /// `given`: a number for each corner, or none.
  void add(MeshFile& file, std::span<const uint32_t> corners, std::span<const uint32_t> given = {});
  /// Divides those that no fan covers (clay/mesh/triangulate.h). Notes how many cross themselves. Indices must be in
  /// range by now. The list is empty afterwards. Throws Cancelled.
  void divide(MeshFile& file, Job* job);

  /// Numbers of each triangle's corners, kNone where a face had none; empty when no face had any.
  std::vector<std::array<uint32_t, 3>> places;

 private:
  std::vector<std::pair<uint32_t, uint32_t>> polygons_;  // first triangle, corners
};

}  // namespace argil::io
