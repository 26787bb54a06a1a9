#pragma once
// Triangle meshes to files: STL (binary, text), OBJ, PLY (binary).

#include <array>
#include <cstdint>
#include <filesystem>
#include <limits>
#include <memory>
#include <span>
#include <string>

#include "clay/base/job.h"
#include "clay/mesh/triangle_mesh.h"
#include "io/models/model_file.h"

namespace argil::io {

struct WriteOptions {
  std::string extension = {};  ///< Chooses the format, such as ".stl"; empty: the ending of the path.
  bool text = false;           ///< STL only: text instead of binary.
  bool doubles = false;        ///< PLY only: 64-bit coordinates, which some readers do not know.
  /// STL only: vertices that its 32-bit numbers would make one are moved apart by a last digit, so that a reader that
  /// welds equal positions finds the same surface. For surfaces whose vertices are all meant to be different.
  bool distinct = false;
  /// For what other formats hold, whose colours part vertices. 3MF: in an object with open edges vertices in one place
  /// become one, as its readers take no others for joined; triangles without an area that this leaves go. glTF: normals
  /// are those of one surface.
  bool weld = false;
  /// glTF only: compressed with Draco (KHR_draco_mesh_compression), to a tenth. Many programs cannot open such files,
  /// Debian's Blender and assimp among them.
  bool draco = false;
  /// glTF with Draco, and .drc: mm that a coordinate may move by quantization; 0: a 131 070th of the model's largest
  /// extent (16 bits). No finer than 2^-29 of the extent.
  double quantization = 0;
  /// mm: what a coordinate may lose to 32-bit numbers before the report warns.
  double tolerance = std::numeric_limits<double>::infinity();
};

struct MeshCounts {
  uint64_t vertices = 0;
  uint64_t triangles = 0;
  bool colours = false;          ///< Each vertex has one. PLY and OBJ keep them, without alpha; STL does not.
  bool triangleColours = false;  ///< Each triangle has one. PLY keeps them, without alpha.
};

struct WriteReport {
  std::string format;
  uint64_t vertices = 0;
  uint64_t triangles = 0;
  uint64_t bytes = 0;
  double rounding = 0;  ///< mm: the most that a coordinate lost to 32-bit numbers.
  /// mm: the farthest that a vertex was moved, where the format rounds on purpose (Draco); measured on all of them.
  double deviation = 0;
  std::string warning;  ///< A sentence when that is more than the tolerance, else empty.
};

/// Writes a mesh that need not exist as a whole: all vertices, in any number of pieces, then all triangles. The file
/// appears at finish(), whole and on the disk; before, and after any error or cancel, there is nothing and an old file
/// stands. Memory: STL keeps 12 bytes a vertex (about 60 when
/// they are kept distinct), the others two buffers. One
/// thread, and one that writes.
class MeshWriter {
 public:
  /// Throws Error: an ending that is not supported, a place that cannot be written, no triangles, too many for the
  /// format.
  MeshWriter(const std::filesystem::path& path, const MeshCounts& counts, const WriteOptions& options = {},
             Job* job = nullptr);
  ~MeshWriter();
  MeshWriter(const MeshWriter&) = delete;
  MeshWriter& operator=(const MeshWriter&) = delete;

  /// mm. Throws Error (kind work): not finite, beyond 32-bit numbers, more than announced, no space; Cancelled.
  void vertices(std::span<const Vec3d> positions);
  /// The same with colours, as many, if they were announced.
  void vertices(std::span<const Vec3d> positions, std::span<const Colour> colours);
  /// Counter-clockwise from outside; indices in the order of vertices(). Throws Error (kind work); Cancelled.
  void triangles(std::span<const std::array<uint32_t, 3>> triangles);
  /// The same with colours, as many, if they were announced.
  void triangles(std::span<const std::array<uint32_t, 3>> triangles, std::span<const Colour> colours);
  /// The triangles that follow are those of this object: OBJ keeps its name.
  void object(const std::string& name);
  /// Throws Error (kind work) when fewer came than announced, or from the disk.
  WriteReport finish();

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// Throws the Error that MeshWriter would for an ending that is not supported or a folder that is not there: before
/// long work, not after it.
void requireWritable(const std::filesystem::path& path, const WriteOptions& options = {});

/// Whether MeshWriter writes what the ending says. Throws Error for one that is not supported.
[[nodiscard]] bool writesPiecewise(const std::filesystem::path& path);

/// A whole mesh at once, as MeshWriter does it.
WriteReport writeMesh(const std::filesystem::path& path, const clay::TriangleMesh& mesh,
                      const WriteOptions& options = {}, Job* job = nullptr);

}  // namespace argil::io
