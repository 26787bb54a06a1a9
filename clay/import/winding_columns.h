#pragma once
// Winding numbers of a closed soup at every voxel, by scan conversion: exact integers, far cheaper than solid angles.

#include <cstdint>
#include <span>
#include <vector>

#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

/// Where each voxel column (x, y) crosses the triangles. What a ray towards +z crosses outwards less what it crosses
/// inwards is the winding number of a closed mesh. Triangles that share an edge see the same bits of its crossings, so
/// that no column slips between them or meets an edge twice: the sum over a column of a closed mesh is exactly zero.
/// Immutable once built; queries may run on any number of threads.
class WindingColumns {
 public:
  /// Positions in voxels, welded: neighbours share indices. "Closed" means that directed edges cancel; overlaps, fins
  /// and non-manifold edges are allowed. Cost and memory (16 bytes each) follow the crossings: the projected area in
  /// voxels².
  explicit WindingColumns(const TriangleMesh& mesh);

  struct Crossing {
    int32_t y;
    int32_t above;  ///< Winding number just below it: the signed count of this crossing and of those above it.
    double z;
  };
  /// Crossings of one column, upwards.
  [[nodiscard]] std::span<const Crossing> column(int32_t x, int32_t y) const noexcept;

  /// Winding number at a voxel. O(log crossings of the row).
  [[nodiscard]] int at(Coord voxel) const noexcept { return at(column(voxel.x, voxel.y), voxel.z); }
  /// The same within a column.
  [[nodiscard]] static int at(std::span<const Crossing> column, double z) noexcept;

 private:
  int32_t firstX_ = 0;
  std::vector<std::vector<Crossing>> rows_;  // by x; sorted by y, then z
};

}  // namespace argil::clay
