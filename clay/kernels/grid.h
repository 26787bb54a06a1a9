#pragma once
// Where the voxels of a clay model lie in the world.

#include "clay/base/vec.h"

namespace argil::clay {

/// Voxel (0, 0, 0) is a sample at `originMm`; voxel coordinate v lies at originMm + voxelMm · v. Distances in the clay
/// are in voxels, so that nothing in it depends on the voxel size; the band is where they are known.
struct Grid {
  double voxelMm = 0.5;            ///< Edge of a voxel: 1e-3 to 1e3 mm.
  Vec3d originMm = Vec3d::Zero();  ///< Each component within ±1e6 mm.
  float band = 3.0f;               ///< Half width of the narrow band in voxels: 2 to 8.

  [[nodiscard]] Vec3d toWorld(const Vec3d& voxel) const { return originMm + voxelMm * voxel; }
  [[nodiscard]] Vec3d toVoxel(const Vec3d& worldMm) const { return (worldMm - originMm) / voxelMm; }

  /// Throws Error when a member is not finite or out of its range.
  void check() const;

  friend bool operator==(const Grid& a, const Grid& b) {
    return a.voxelMm == b.voxelMm && a.originMm == b.originMm && a.band == b.band;
  }
};

}  // namespace argil::clay
