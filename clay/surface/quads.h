#pragma once
// The quads of a surface with their corners, wherever these are kept.

#include <array>
#include <cstdint>

#include "clay/surface/surface.h"

namespace argil::clay {

/// A vertex of a surface.
struct Corner {
  const BrickMesh* mesh = nullptr;
  uint32_t index = 0;
  /// In voxels, from `origin` (a brick): exact near it.
  [[nodiscard]] Vec3d from(Coord origin) const {
    const Coord step = mesh->brick - origin;
    return Vec3d(step.x, step.y, step.z) * 8 + mesh->positions[index].cast<double>();
  }
};

/// Calls visit(corners) for each quad of a brick's mesh.
template <class Visit>
void forEachQuad(const Surface& surface, const BrickMesh& mesh, const Visit& visit) {
  std::array<const BrickMesh*, 8> lower{&mesh};
  for (const auto& quad : mesh.quads) {
    std::array<Corner, 4> corners;
    for (size_t k = 0; k < 4; ++k) {
      const uint32_t n = quad[k] >> kVertexRefBits;
      if (!lower[n]) lower[n] = surface.find(mesh.brick - Coord{int(n & 1), int(n >> 1 & 1), int(n >> 2)});
      corners[k] = {lower[n], static_cast<uint32_t>(quad[k] & kVertexRefIndex)};
    }
    visit(corners);
  }
}

}  // namespace argil::clay
