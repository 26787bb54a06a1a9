#pragma once
// Faces of more than three corners become triangles once all vertices are known. For this module's files.

#include <cstdint>
#include <span>
#include <utility>
#include <vector>

#include "io/models/mesh_file.h"

namespace argil::io {

/// Collects the faces of one file. Each has its place among the triangles, two fewer than it has corners, from the
/// beginning, so that colours and objects can name them before their shape is known.
class PolygonList {
 public:
  /// Adds a face to the file's triangles, as a fan about its first corner, and counts it. At least three corners.
  void add(MeshFile& file, std::span<const uint32_t> corners);
  /// Divides those that no fan covers (clay/mesh/triangulate.h). Notes how many cross themselves. Indices must be in
  /// range by now. The list is empty afterwards. Throws Cancelled.
  void divide(MeshFile& file, Job* job);

 private:
  std::vector<std::pair<uint32_t, uint32_t>> polygons_;  // first triangle, corners
};

}  // namespace argil::io
