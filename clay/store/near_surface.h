#pragma once
// The part of a surface that is nearest to a place. This module's own.

#include <vector>

#include "clay/store/sampler.h"

namespace argil::clay {

/// A voxel beside the surface, as it is seen from a place.
struct NearVoxel {
  float distance;  ///< From the place to the voxel, voxels.
  float weight;    ///< Larger the nearer it lies to the surface, and to the place beside the nearest one. 0 to 2.
  Vec3f normal;    ///< Of the surface there, outwards; unit length.
  Coord brick;
  int voxel;  ///< In the brick.
};

/// Voxels within one voxel of the surface whose distance from `place` exceeds that of the nearest one by no more than
/// two voxels; none where that is farther than `reach`. In no fixed order: sums over them must not depend on it. Cost:
/// that of the bricks up to twice as far as the nearest voxel.
[[nodiscard]] std::vector<NearVoxel> surfaceNear(Sampler& field, const Vec3d& place, double reach);

}  // namespace argil::clay
