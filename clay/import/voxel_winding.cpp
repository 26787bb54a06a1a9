#include "clay/import/voxel_winding.h"

#include <algorithm>
#include <map>
#include <numeric>

namespace argil::clay {

namespace {

/// Cones over the rims of all holes: with them the mesh is closed in the sense of WindingColumns.
TriangleMesh capsOf(const RepairedMesh& repaired) {
  const auto& positions = repaired.mesh.positions;
  std::vector<uint32_t> set(positions.size());
  std::iota(set.begin(), set.end(), 0u);
  const auto find = [&](uint32_t i) {
    while (set[i] != i) i = set[i] = set[set[i]];
    return i;
  };
  for (const OpenEdge& e : repaired.openEdges) {
    const uint32_t a = find(e.from), b = find(e.to);
    set[std::max(a, b)] = std::min(a, b);
  }
  struct Rim {
    Vec3d sum = Vec3d::Zero(), low, high;
    size_t count = 0;
    uint32_t apex = 0;
  };
  std::map<uint32_t, Rim> rims;
  for (const OpenEdge& e : repaired.openEdges) {
    Rim& rim = rims[find(e.from)];
    const Vec3d& p = positions[e.from];
    rim.low = rim.count ? Vec3d(rim.low.cwiseMin(p)) : p;
    rim.high = rim.count ? Vec3d(rim.high.cwiseMax(p)) : p;
    rim.sum += p;
    ++rim.count;
  }
  TriangleMesh caps{positions, {}};
  for (auto& [root, rim] : rims) {
    rim.apex = uint32_t(caps.positions.size());
    // Off the rim's own plane, which may be one of voxels: no voxel shall lie on a cap.
    const double size = 1 + 0.1 * (rim.high - rim.low).norm();
    caps.positions.push_back(rim.sum / double(rim.count) + size * Vec3d(0.3183098861, 0.5772156649, 0.7320508075));
  }
  for (const OpenEdge& e : repaired.openEdges) {
    for (uint32_t k = 0; k < e.times; ++k) caps.triangles.push_back({e.to, e.from, rims[find(e.from)].apex});
  }
  return caps;
}

}  // namespace

VoxelWinding::VoxelWinding(const RepairedMesh& repaired) {
  if (repaired.openEdges.empty()) {
    columns_.emplace(repaired.mesh);
    return;
  }
  TriangleMesh closed = capsOf(repaired);
  caps_.emplace(closed);
  closed.triangles.insert(closed.triangles.end(), repaired.mesh.triangles.begin(), repaired.mesh.triangles.end());
  columns_.emplace(closed);
}

float VoxelWinding::at(Column column, Coord voxel) const noexcept {
  const int whole = WindingColumns::at(column, voxel.z);
  return caps_ ? float(whole - caps_->at(voxel.toVec3d())) : float(whole);
}

}  // namespace argil::clay
