#pragma once
// Triangle meshes from files: STL, OBJ, PLY, OFF.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "clay/job.h"
#include "clay/triangle_mesh.h"

namespace argil::io {

/// What a file held. Positions are in the file's own units: these formats name none, and nothing is scaled here. All
/// coordinates are finite, all indices in range, and there is at least one triangle; nothing is promised about
/// topology.
struct MeshFile {
  clay::TriangleMesh mesh;
  std::string format;     ///< "STL (binary)", "STL (text)", "OBJ", "PLY (text)", "PLY (binary)", "OFF".
  uint64_t faces = 0;     ///< As the file has them, before polygons became triangles.
  uint64_t polygons = 0;  ///< Faces of more than three corners, split as fans about their first corner.
  bool welded = false;    ///< Vertices of equal coordinates were made one (STL repeats them in every triangle).
  std::vector<std::string> notes;  ///< What was there and is not kept, a sentence each, for the person.
};

/// Reads a mesh; the content says which format it is, the ending of the name only where the content does not.
/// Throws Error, one line that names the file, what is wrong, the line or byte, and what to do: for what cannot be
/// opened, is no regular file, is empty, is cut off, has numbers that are not finite, indices out of range or no
/// triangle. Counts that a file claims are checked against its length before memory is taken for them. Throws
/// Cancelled. Any thread.
[[nodiscard]] MeshFile readMesh(const std::filesystem::path& path, Job* job = nullptr);

/// The same from memory; `name` stands for the path in messages and gives the ending.
[[nodiscard]] MeshFile parseMesh(std::span<const std::byte> bytes, const std::string& name, Job* job = nullptr);

}  // namespace argil::io
