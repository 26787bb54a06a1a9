#pragma once
// Winding numbers of a mesh with holes at voxels: nearly all of it by scan conversion.

#include <optional>
#include <span>

#include "clay/import/mesh_repair.h"
#include "clay/import/winding_columns.h"
#include "clay/mesh/winding_number.h"

namespace argil::clay {

/// Cones over the rims of all holes close the mesh. Winding numbers of mesh and cones together are integers
/// (WindingColumns); less those of the cones alone, which are few triangles (WindingNumber), they are the mesh's own,
/// wherever the cones lie. Immutable once built; queries may run on any number of threads.
class VoxelWinding {
 public:
  /// Positions in voxels.
  explicit VoxelWinding(const RepairedMesh& repaired);

  /// Without holes every answer is an integer.
  [[nodiscard]] bool open() const { return caps_.has_value(); }
  [[nodiscard]] float at(Coord voxel) const noexcept { return at(column(voxel.x, voxel.y), voxel); }

  using Column = std::span<const WindingColumns::Crossing>;
  /// For many voxels of a column: its crossings, found once.
  [[nodiscard]] Column column(int32_t x, int32_t y) const noexcept { return columns_->column(x, y); }
  /// `column`: the one through the voxel.
  [[nodiscard]] float at(Column column, Coord voxel) const noexcept;

  /// Tells whether rims are so much of the mesh that fill() is the faster way to the numbers of a brick.
  [[nodiscard]] bool mostlyRims() const { return !capTriangles_.empty(); }
  /// Finds the numbers of the 8 · 8 · 8 voxels from `first` on, x · 64 + y · 8 + z, where mostlyRims(): the caps that
  /// are near are summed at each voxel, the others at 27 places of the brick and interpolated. Within 0.01 of at().
  void fill(Coord first, std::span<float, 512> numbers) const;

 private:
  std::optional<WindingNumber> caps_;
  std::vector<WindingNumber::Triangle> capTriangles_;  // where mostlyRims()
  std::optional<WindingColumns> columns_;
};

}  // namespace argil::clay
