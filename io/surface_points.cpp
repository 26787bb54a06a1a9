#include "io/surface_points.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include "clay/error.h"

namespace argil::io {

namespace {

using clay::TriangleMesh;

// A triangle flatter than this, squared area against squared length of its longest edge, has no direction of its own.
constexpr double kFlat = 1e-24;

uint32_t packed(const Colour& c) {
  return uint32_t(c.red) << 24 | uint32_t(c.green) << 16 | uint32_t(c.blue) << 8 | c.alpha;
}

// The corners (3 × triangle + which) around each vertex, in their order: 4 bytes each, as a large mesh has many.
class Corners {
 public:
  explicit Corners(const TriangleMesh& mesh) : first_(mesh.positions.size() + 2), corners_(3 * mesh.triangles.size()) {
    // Counts are kept two places up, so that filling the list moves each start to its final place.
    for (const auto& triangle : mesh.triangles)
      for (const uint32_t v : triangle) ++first_[v + 2];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
      for (size_t k = 0; k < 3; ++k) corners_[first_[mesh.triangles[t][k] + 1]++] = uint32_t(3 * t + k);
  }
  [[nodiscard]] std::span<const uint32_t> around(size_t vertex) const {
    return std::span(corners_).subspan(first_[vertex], first_[vertex + 1] - first_[vertex]);
  }

 private:
  std::vector<uint32_t> first_, corners_;
};

// Gives each corner around a vertex the group whose normal it shares.
class SmoothGroups {
 public:
  explicit SmoothGroups(const TriangleMesh& mesh)
      : mesh_(mesh), least_(std::cos(kCreaseDegrees * std::numbers::pi / 180)) {}

  // group[i]: the lowest place of a corner of the same group.
  const std::vector<uint32_t>& of(std::span<const uint32_t> corners) {
    group_.resize(corners.size());
    std::iota(group_.begin(), group_.end(), 0u);
    edges_.clear();
    facing_.clear();
    for (uint32_t i = 0; i < corners.size(); ++i) {
      const auto& triangle = mesh_.triangles[corners[i] / 3];
      const size_t k = corners[i] % 3;
      edges_.emplace_back(triangle[(k + 1) % 3], i);
      edges_.emplace_back(triangle[(k + 2) % 3], i);
      facing_.push_back(facing(triangle));
    }
    // Corners that share an edge stand side by side; where more than two do, each with the next.
    std::sort(edges_.begin(), edges_.end());
    for (size_t i = 1; i < edges_.size(); ++i) {
      const auto [end, a] = edges_[i - 1];
      const auto [other, b] = edges_[i];
      if (end != other || !smooth(facing_[a], facing_[b])) continue;
      const uint32_t low = std::min(root(a), root(b)), high = std::max(root(a), root(b));
      group_[high] = low;
    }
    for (uint32_t i = 0; i < group_.size(); ++i) group_[i] = root(i);
    return group_;
  }

 private:
  [[nodiscard]] Vec3d facing(const std::array<uint32_t, 3>& t) const {
    const Vec3d ab = mesh_.positions[t[1]] - mesh_.positions[t[0]], ac = mesh_.positions[t[2]] - mesh_.positions[t[0]];
    const Vec3d normal = ab.cross(ac);
    const double longest = std::max({ab.squaredNorm(), ac.squaredNorm(), (ac - ab).squaredNorm()}),
                 length2 = normal.squaredNorm();
    return length2 > kFlat * longest * longest ? Vec3d(normal / std::sqrt(length2)) : Vec3d::Zero();
  }
  [[nodiscard]] bool smooth(const Vec3d& a, const Vec3d& b) const {
    return a.isZero() || b.isZero() || a.dot(b) >= least_;
  }
  [[nodiscard]] uint32_t root(uint32_t i) {
    while (group_[i] != i) i = group_[i] = group_[group_[i]];
    return i;
  }

  const TriangleMesh& mesh_;
  double least_;
  std::vector<uint32_t> group_;
  std::vector<std::pair<uint32_t, uint32_t>> edges_;  // the edge's other end, the corner's place
  std::vector<Vec3d> facing_;
};

// What a corner adds to the normal of its vertex.
Vec3d weighted(const TriangleMesh& mesh, uint32_t corner) {
  const auto& t = mesh.triangles[corner / 3];
  const size_t k = corner % 3;
  const Vec3d& at = mesh.positions[t[k]];
  const Vec3d a = mesh.positions[t[(k + 1) % 3]] - at, b = mesh.positions[t[(k + 2) % 3]] - at;
  const double lengths = a.squaredNorm() * b.squaredNorm();
  return lengths > 0 ? Vec3d(a.cross(b) / lengths) : Vec3d::Zero();
}

std::array<float, 3> unit(const Vec3d& v) {
  const double length = v.norm();
  if (!(length > 0) || !std::isfinite(length)) return {0, 0, 1};
  return {float(v.x() / length), float(v.y() / length), float(v.z() / length)};
}

}  // namespace

SurfacePoints pointsOf(const ModelObject& object, Normals normals) {
  const TriangleMesh& mesh = object.mesh;
  const bool byTriangle = !object.triangleColours.empty(), shaded = normals == Normals::creased;
  SurfacePoints points;
  if (!byTriangle) points.colours = object.vertexColours;
  if (!byTriangle && !shaded) return points;

  if (mesh.triangles.size() > UINT32_MAX / 3)
    throw Error("the model has more than " + std::to_string(UINT32_MAX / 3) + " triangles; reduce it first",
                Error::Kind::work);
  const Corners corners(mesh);
  SmoothGroups groups(mesh);
  struct Wanted {
    uint32_t group, colour, place;  // of the corner around its vertex
    [[nodiscard]] auto key() const { return std::tie(group, colour, place); }
  };
  std::vector<Wanted> wanted;
  std::vector<Vec3d> sums;  // by group
  points.triangles.resize(mesh.triangles.size());
  // As many as most meshes need: a list that grows holds its items twice.
  points.vertex.reserve(mesh.positions.size());
  if (shaded) points.normals.reserve(mesh.positions.size());
  for (uint32_t v = 0; v < mesh.positions.size(); ++v) {
    const std::span<const uint32_t> around = corners.around(v);
    const std::span<const uint32_t> group = shaded ? std::span(groups.of(around)) : std::span<const uint32_t>();
    wanted.clear();
    sums.assign(shaded ? around.size() : 0, Vec3d::Zero());
    for (uint32_t i = 0; i < around.size(); ++i) {
      wanted.push_back({shaded ? group[i] : 0, byTriangle ? packed(object.triangleColours[around[i] / 3]) : 0, i});
      if (shaded) sums[group[i]] += weighted(mesh, around[i]);
    }
    std::sort(wanted.begin(), wanted.end(), [](const Wanted& a, const Wanted& b) { return a.key() < b.key(); });
    for (size_t i = 0; i < wanted.size(); ++i) {
      const Wanted& each = wanted[i];
      const uint32_t corner = around[each.place];
      if (i == 0 || each.group != wanted[i - 1].group || each.colour != wanted[i - 1].colour) {
        points.vertex.push_back(v);
        if (byTriangle) points.colours.push_back(object.triangleColours[corner / 3]);
        if (shaded) points.normals.push_back(unit(sums[each.group]));
      }
      points.triangles[corner / 3][corner % 3] = uint32_t(points.vertex.size() - 1);
    }
  }
  if (points.vertex.size() == mesh.positions.size()) {  // Each vertex is one point, unless some belong to no triangle.
    bool same = true;
    for (uint32_t i = 0; i < points.vertex.size() && same; ++i) same = points.vertex[i] == i;
    if (same) {
      std::vector<uint32_t>().swap(points.vertex);
      std::vector<std::array<uint32_t, 3>>().swap(points.triangles);
    }
  }
  if (!byTriangle && !object.vertexColours.empty() && !points.vertex.empty()) {
    points.colours.clear();
    for (const uint32_t v : points.vertex) points.colours.push_back(object.vertexColours[v]);
  }
  return points;
}

}  // namespace argil::io
