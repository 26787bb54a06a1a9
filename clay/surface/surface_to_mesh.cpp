#include <array>
#include <unordered_map>

#include "clay/store/brick_set.h"
#include "clay/surface/surface.h"

namespace argil::clay {

TriangleMesh Surface::toMesh() const {
  TriangleMesh mesh;
  mesh.positions.reserve(vertexCount());
  mesh.triangles.reserve(2 * quadCount());
  std::unordered_map<Coord, uint32_t, CoordHash> first;
  const Grid& grid = version().grid();
  forEach([&](const BrickMesh& brick) {
    first[brick.brick] = static_cast<uint32_t>(mesh.positions.size());
    const Vec3d origin = (brick.brick * kBrickEdge).toVec3d();
    for (const Vec3f& p : brick.positions) mesh.positions.push_back(grid.toWorld(origin + p.cast<double>()));
  });
  forEach([&](const BrickMesh& brick) {
    std::array<uint32_t, 8> base{};
    for (int k = 0; k < 8; ++k) {
      const auto it = first.find(brick.brick - Coord{k & 1, (k >> 1) & 1, k >> 2});
      if (it != first.end()) base[static_cast<size_t>(k)] = it->second;
    }
    for (const auto& quad : brick.quads) {
      std::array<uint32_t, 4> v;
      for (size_t i = 0; i < 4; ++i) v[i] = base[quad[i] >> kVertexRefBits] + (quad[i] & kVertexRefIndex);
      mesh.triangles.push_back({v[0], v[1], v[2]});
      mesh.triangles.push_back({v[0], v[2], v[3]});
    }
  });
  return mesh;
}

}  // namespace argil::clay
