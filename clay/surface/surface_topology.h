#pragma once
// What holds a surface together, without a mesh of it: for surfaces that have no room beside themselves.

#include <functional>

#include "clay/mesh/mesh_topology.h"
#include "clay/surface/surface.h"

namespace argil::clay {

/// As checkTopology(surface.toMesh()) with each vertex moved by `place` (null: not at all), in order of the mesh.
/// Memory: 4 bytes a vertex, and slabs of 64 voxels.
[[nodiscard]] TopologyReport surfaceTopology(const Surface& surface,
                                             const std::function<Vec3d(const Vec3d&)>& place = nullptr);

}  // namespace argil::clay
