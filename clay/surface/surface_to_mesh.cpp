#include <iterator>

#include "clay/base/memory_guard.h"
#include "clay/store/brick_set.h"
#include "clay/surface/surface_state.h"

namespace argil::clay {

void Surface::forEachSlab(SlabOf what, const std::function<void(const SurfaceSlab&)>& visit) const {
  SurfaceSlab slab;
  // Of the bricks of this slab and of the one before: where their vertices begin.
  std::unordered_map<Coord, uint32_t, CoordHash> first, before;
  const Grid& grid = version().grid();
  std::vector<const BrickMesh*> bricks;
  uint32_t vertices = 0;
  const auto finish = [&] {
    if (bricks.empty()) return;
    slab.firstVertex = vertices;
    slab.positions.clear();
    slab.triangles.clear();
    for (const BrickMesh* brick : bricks) {
      first[brick->brick] = vertices;
      vertices += static_cast<uint32_t>(brick->positions.size());
      if (what == SlabOf::triangles) continue;
      const Vec3d origin = (brick->brick * kBrickEdge).toVec3d();
      for (const Vec3f& p : brick->positions) slab.positions.push_back(grid.toWorld(origin + p.cast<double>()));
    }
    for (const BrickMesh* brick : bricks) {
      if (what == SlabOf::vertices) break;
      std::array<uint32_t, 8> base{};
      for (int k = 0; k < 8; ++k) {
        const Coord owner = brick->brick - Coord{k & 1, (k >> 1) & 1, k >> 2};
        const auto& known = owner.x >> 3 == brick->brick.x >> 3 ? first : before;
        if (const auto it = known.find(owner); it != known.end()) base[static_cast<size_t>(k)] = it->second;
      }
      for (const auto& quad : brick->quads) {
        std::array<uint32_t, 4> v;
        for (size_t i = 0; i < 4; ++i) v[i] = base[quad[i] >> kVertexRefBits] + (quad[i] & kVertexRefIndex);
        slab.triangles.push_back({v[0], v[1], v[2]});
        slab.triangles.push_back({v[0], v[2], v[3]});
      }
    }
    visit(slab);
    before.swap(first);
    first.clear();
    bricks.clear();
  };
  int32_t x = 0;
  state_->forEach([&](const HeldMesh& brick) {
    if (brick.brick.x >> 3 != x) {
      finish();
      x = brick.brick.x >> 3;
    }
    bricks.push_back(&brick);
  });
  finish();
}

TriangleMesh Surface::toMesh() const {
  TriangleMesh mesh;
  claimMemory(vertexCount() * sizeof mesh.positions[0] + 2 * quadCount() * sizeof mesh.triangles[0]);
  mesh.positions.reserve(vertexCount());
  mesh.triangles.reserve(2 * quadCount());
  forEachSlab(SlabOf::both, [&](const SurfaceSlab& slab) {
    mesh.positions.insert(mesh.positions.end(), slab.positions.begin(), slab.positions.end());
    mesh.triangles.insert(mesh.triangles.end(), slab.triangles.begin(), slab.triangles.end());
  });
  return mesh;
}

}  // namespace argil::clay
