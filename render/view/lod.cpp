#include "render/view/lod.h"

#include <algorithm>
#include <cmath>
#include <cstdlib>

#include "clay/surface/rim_vertices.h"

namespace argil::render {
namespace {

constexpr uint16_t kNone = UINT16_MAX;
/// Vertices on creases stand up to clay::kVertexReach outside of their cell.
static_assert(kLastCreaseUnits == int32_t((clay::kBrickEdge - 1 - clay::kVertexReach) * kUnitsPerVoxel));

/// Of the vertices in one group of cells: those on one side along the axis that most of them face along, so that a thin
/// wall does not collapse and each side keeps its light.
struct Cluster {
  Units sum{};
  int32_t count = 0;
  uint32_t nearest = UINT32_MAX;
  uint16_t vertex = kNone;
};

/// Where a vertex faces, in 32 767ths of the sum of the three. Integers, as all here: a device finds the same.
Units facing(clay::PackedNormal normal) {
  constexpr int32_t kOne = 32767;
  const int32_t u = normal.u, v = normal.v, up = kOne - std::abs(u) - std::abs(v);
  if (up >= 0) return {u, v, up};
  return {(kOne - std::abs(v)) * (u < 0 ? -1 : 1), (kOne - std::abs(u)) * (v < 0 ? -1 : 1), up};
}

/// The square of the distance from the mean, in steps of 8 units: groups are so small that it fits.
uint32_t offMean(const Units& at, const Cluster& cluster) {
  uint32_t square = 0;
  for (size_t axis = 0; axis < 3; ++axis) {
    const int32_t off = (at[axis] - cluster.sum[axis] / cluster.count) / 8;
    square += uint32_t(off * off);
  }
  return square;
}

/// Wider cones hide nothing worth the test.
constexpr float kWidest = 0.05f;

}  // namespace

Units inUnits(const Vec3f& voxels) {
  // The nearest unit. Added to a number above zero, since then dropping the fraction rounds down, in one instruction.
  constexpr int kAbove = 2 * clay::kBrickEdge;  // no vertex stands so far outside of its brick
  const auto one = [](float voxel) {
    return int32_t(double(voxel) * kUnitsPerVoxel + (kAbove * double(kUnitsPerVoxel) + 0.5)) - kAbove * kUnitsPerVoxel;
  };
  return {one(voxels.x()), one(voxels.y()), one(voxels.z())};
}

void representatives(const clay::BrickMesh& mesh, int level, unsigned locked, std::vector<uint16_t>& out) {
  const size_t count = mesh.positions.size();
  out.resize(count);
  std::array<Cluster, 128> clusters;
  std::array<Units, 64> spread{};        // of where they face
  std::vector<uint16_t>& cluster = out;  // first the group, then the cluster, then what stands for the vertex
  const int size = kGroupCells[size_t(level)], groups = (clay::kBrickEdge + size - 1) / size;
  for (size_t i = 0; i < count; ++i) {
    const Units at = inUnits(mesh.positions[i]);
    std::array<int, 3> cell;
    bool fixed = false;
    const int32_t last = (mesh.normals[i].v & 1) != 0 ? kLastCreaseUnits : kLastLayerUnits;
    for (size_t axis = 0; axis < 3; ++axis) {
      cell[axis] = std::clamp(at[axis] / kUnitsPerVoxel, 0, clay::kBrickEdge - 1);
      fixed |= (locked >> axis & 1) != 0 && at[axis] >= last;
    }
    if (fixed) {
      cluster[i] = kNone;
      continue;
    }
    const auto group = size_t((cell[0] / size * groups + cell[1] / size) * groups + cell[2] / size);
    cluster[i] = uint16_t(group);
    const Units way = facing(mesh.normals[i]);
    for (size_t axis = 0; axis < 3; ++axis) spread[group][axis] += std::abs(way[axis]);
  }
  for (size_t i = 0; i < count; ++i) {
    if (cluster[i] == kNone) continue;
    const Units& along = spread[cluster[i]];
    const auto axis = size_t(std::max_element(along.begin(), along.end()) - along.begin());
    cluster[i] = uint16_t(2 * cluster[i] + (facing(mesh.normals[i])[axis] < 0 ? 1 : 0));
    Cluster& c = clusters[cluster[i]];
    const Units at = inUnits(mesh.positions[i]);
    for (size_t each = 0; each < 3; ++each) c.sum[each] += at[each];
    ++c.count;
  }
  for (size_t i = 0; i < count; ++i) {
    if (cluster[i] == kNone) continue;
    Cluster& c = clusters[cluster[i]];
    const uint32_t off = offMean(inUnits(mesh.positions[i]), c);
    if (off < c.nearest) {
      c.vertex = uint16_t(i);
      c.nearest = off;
    }
  }
  for (size_t i = 0; i < count; ++i) out[i] = cluster[i] == kNone ? uint16_t(i) : clusters[cluster[i]].vertex;
}

bool NormalCone::facesAway(const Vec3d& centre, double radius, const Vec3d& eye) const {
  if (cosine < kWidest) return false;
  const Vec3d to = centre - eye;
  const double length = to.norm();
  if (length <= radius) return false;
  const double along = std::clamp(to.dot(axis.cast<double>()) / length, -1.0, 1.0), cosCone = double(cosine);
  // cos(angle + cone) · length: how far the least turned triangle faces away, over the ball.
  const double least = along * cosCone - std::sqrt(1 - along * along) * std::sqrt(std::max(0.0, 1 - cosCone * cosCone));
  return least * length > radius;
}

bool NormalCone::facesAway(const Vec3d& direction) const {
  if (cosine < kWidest) return false;
  const double along = std::clamp(direction.dot(axis.cast<double>()), -1.0, 1.0), cosCone = double(cosine);
  return along > 0 && along * cosCone > std::sqrt(1 - along * along) * std::sqrt(std::max(0.0, 1 - cosCone * cosCone));
}

void ConeBuilder::add(const Vec3f& a, const Vec3f& b, const Vec3f& c) {
  const Vec3f normal = (b - a).cross(c - a);
  const float length = normal.norm();
  if (!(length > 0)) return;
  normals_.push_back(normal / length);
  sum_ += normal;
}

NormalCone ConeBuilder::cone() const {
  NormalCone cone;
  const float length = sum_.norm();
  if (!(length > 0)) return cone;
  cone.axis = sum_ / length;
  cone.cosine = 1;
  for (const Vec3f& n : normals_) cone.cosine = std::min(cone.cosine, n.dot(cone.axis));
  cone.cosine -= kConeSlack;
  return cone;
}

}  // namespace argil::render
