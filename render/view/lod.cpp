#include "render/view/lod.h"

#include <algorithm>
#include <cmath>

#include "clay/surface/sharp_vertices.h"

namespace argil::render {
namespace {

constexpr uint16_t kNone = UINT16_MAX;
/// Vertices of a brick's last layer of cells lie behind this: fine ones stand up to clay::kSharpReach outside of their
/// cell.
constexpr float kLastLayer = float(clay::kBrickEdge - 1) - clay::kSharpReach;

/// Of the vertices in one group of cells: those on one side along the axis that most of them face along, so that a thin
/// wall does not collapse and each side keeps its light.
struct Cluster {
  Vec3f sum = Vec3f::Zero();
  uint32_t count = 0;
  float nearest = 0;
  uint16_t vertex = kNone;
};

/// Rounding of normals is 0.006°; their lengths may be off by as much.
constexpr float kConeSlack = 2e-4f;
/// Wider cones hide nothing worth the test.
constexpr float kWidest = 0.05f;

}  // namespace

void representatives(const clay::BrickMesh& mesh, int level, unsigned locked, std::vector<uint16_t>& out) {
  const size_t count = mesh.positions.size();
  out.resize(count);
  std::array<Cluster, 128> clusters;
  std::array<Vec3f, 64> spread;  // of normals along each axis
  std::array<bool, 64> met{};
  std::vector<uint16_t>& cluster = out;  // first the group, then the cluster, then what stands for the vertex
  const int size = kGroupCells[size_t(level)], groups = (clay::kBrickEdge + size - 1) / size;
  for (size_t i = 0; i < count; ++i) {
    const Vec3f& p = mesh.positions[i];
    std::array<int, 3> cell;
    bool fixed = false;
    for (int axis = 0; axis < 3; ++axis) {
      cell[size_t(axis)] = std::clamp(int(std::floor(p[axis])), 0, clay::kBrickEdge - 1);
      fixed |= (locked >> axis & 1) != 0 && p[axis] >= kLastLayer;
    }
    if (fixed) {
      cluster[i] = kNone;
      continue;
    }
    const auto group = size_t((cell[0] / size * groups + cell[1] / size) * groups + cell[2] / size);
    cluster[i] = uint16_t(group);
    if (!met[group]) {
      met[group] = true;
      spread[group].setZero();
    }
    spread[group] += mesh.normals[i].unpack().cwiseAbs();
  }
  for (size_t i = 0; i < count; ++i) {
    if (cluster[i] == kNone) continue;
    Eigen::Index axis = 0;
    spread[cluster[i]].maxCoeff(&axis);
    cluster[i] = uint16_t(2 * cluster[i] + (mesh.normals[i].unpack()[axis] < 0 ? 1 : 0));
    clusters[cluster[i]].sum += mesh.positions[i];
    ++clusters[cluster[i]].count;
  }
  for (size_t i = 0; i < count; ++i) {
    if (cluster[i] == kNone) continue;
    Cluster& c = clusters[cluster[i]];
    const float away = (mesh.positions[i] * float(c.count) - c.sum).squaredNorm();
    if (c.vertex == kNone || away < c.nearest) {
      c.vertex = uint16_t(i);
      c.nearest = away;
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
