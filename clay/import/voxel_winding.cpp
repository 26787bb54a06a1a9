#include "clay/import/voxel_winding.h"

#include <algorithm>
#include <array>
#include <map>
#include <numeric>

#include "clay/mesh/nearest_triangle.h"

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

/// The caps of a mesh with more edges at holes than this share of its triangles are summed brick by brick, if they are
/// so few that each brick can look at all of them.
constexpr double kMostlyRims = 0.5;
constexpr size_t kMostCaps = 4096;
/// Voxels from a brick's middle within which caps are near: those beyond bend so little over the brick that polynomials
/// of second order through 27 places follow them.
constexpr double kNear = 17;

/// Shares of the values at 0, 3.5 and 7 in the value at a voxel of a brick.
std::array<std::array<double, 3>, 8> sharesOfThree() {
  std::array<std::array<double, 3>, 8> shares{};
  for (size_t i = 0; i < 8; ++i) {
    const double x = double(i) / 3.5;
    shares[i] = {(x - 1) * (x - 2) / 2, x * (2 - x), x * (x - 1) / 2};
  }
  return shares;
}

}  // namespace

VoxelWinding::VoxelWinding(const RepairedMesh& repaired) {
  if (repaired.openEdges.empty()) {
    columns_.emplace(repaired.mesh);
    return;
  }
  TriangleMesh closed = capsOf(repaired);
  caps_.emplace(closed);
  if (double(repaired.openEdges.size()) > kMostlyRims * double(repaired.mesh.triangles.size()) &&
      closed.triangles.size() <= kMostCaps) {
    for (const auto& [a, b, c] : closed.triangles)
      capTriangles_.push_back({closed.positions[a], closed.positions[b], closed.positions[c]});
  }
  closed.triangles.insert(closed.triangles.end(), repaired.mesh.triangles.begin(), repaired.mesh.triangles.end());
  columns_.emplace(closed);
}

void VoxelWinding::fill(Coord first, std::span<float, 512> numbers) const {
  static const std::array<std::array<double, 3>, 8> kShares = sharesOfThree();
  const Vec3d low = first.toVec3d(), middle = low + Vec3d::Constant(3.5);
  std::vector<WindingNumber::Triangle> near;
  for (const WindingNumber::Triangle& cap : capTriangles_) {
    const Vec3d at = nearestOnTriangle(middle, cap[0], cap[1], cap[2]);
    if ((at - middle).squaredNorm() < kNear * kNear) near.push_back(cap);
  }
  std::array<double, 27> far;
  for (size_t i = 0; i < far.size(); ++i) {
    const Vec3d place = low + 3.5 * Vec3d(double(i / 9), double(i / 3 % 3), double(i % 3));
    far[i] = caps_->at(place) - WindingNumber::exact(near, place);
  }
  for (int x = 0; x < 8; ++x) {
    for (int y = 0; y < 8; ++y) {
      std::array<double, 3> along{};
      for (size_t i = 0; i < far.size(); ++i)
        along[i % 3] += kShares[size_t(x)][i / 9] * kShares[size_t(y)][i / 3 % 3] * far[i];
      const Column crossings = column(first.x + x, first.y + y);
      for (int z = 0; z < 8; ++z) {
        const Coord voxel{first.x + x, first.y + y, first.z + z};
        const auto& shares = kShares[size_t(z)];
        const double caps = shares[0] * along[0] + shares[1] * along[1] + shares[2] * along[2] +
                            (near.empty() ? 0 : WindingNumber::exact(near, voxel.toVec3d()));
        numbers[size_t(x * 64 + y * 8 + z)] = float(WindingColumns::at(crossings, voxel.z) - caps);
      }
    }
  }
}

float VoxelWinding::at(Column column, Coord voxel) const noexcept {
  const int whole = WindingColumns::at(column, voxel.z);
  return caps_ ? float(whole - caps_->at(voxel.toVec3d())) : float(whole);
}

}  // namespace argil::clay
