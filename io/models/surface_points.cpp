#include "io/models/surface_points.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <numeric>
#include <span>
#include <string>
#include <tuple>
#include <utility>

#include "clay/base/error.h"
#include "clay/mesh/weld.h"

namespace argil::io {

namespace {

using clay::TriangleMesh;

// A triangle flatter than this, squared area against squared length of its longest edge, has no direction of its own.
constexpr double kFlat = 1e-24;

uint32_t packed(const Colour& c) {
  return uint32_t(c.red) << 24 | uint32_t(c.green) << 16 | uint32_t(c.blue) << 8 | c.alpha;
}

// The place of each vertex by number: its own, or what it shares with others of equal coordinates.
class Places {
 public:
  Places(const TriangleMesh& mesh, bool joined) : count_(mesh.positions.size()) {
    if (!joined) return;
    clay::VertexWelder welder;
    of_.resize(mesh.positions.size());
    welder.add(mesh.positions, of_);
    count_ = welder.positions().size();
  }
  [[nodiscard]] uint32_t of(uint32_t vertex) const { return of_.empty() ? vertex : of_[vertex]; }
  [[nodiscard]] size_t count() const { return count_; }

 private:
  size_t count_;
  std::vector<uint32_t> of_;
};

// The corners (3 × triangle + which) around each place, in their order: 4 bytes each, as a large mesh has many.
class Corners {
 public:
  Corners(const TriangleMesh& mesh, const Places& places)
      : first_(places.count() + 2), corners_(3 * mesh.triangles.size()) {
    // Counts are kept two places up, so that filling the list moves each start to its final place.
    for (const auto& triangle : mesh.triangles)
      for (const uint32_t v : triangle) ++first_[places.of(v) + 2];
    std::partial_sum(first_.begin(), first_.end(), first_.begin());
    for (size_t t = 0; t < mesh.triangles.size(); ++t)
      for (size_t k = 0; k < 3; ++k) corners_[first_[places.of(mesh.triangles[t][k]) + 1]++] = uint32_t(3 * t + k);
  }
  [[nodiscard]] std::span<const uint32_t> around(size_t place) const {
    return std::span(corners_).subspan(first_[place], first_[place + 1] - first_[place]);
  }

 private:
  std::vector<uint32_t> first_, corners_;
};

// Gives each corner around a place the group whose normal it shares.
class SmoothGroups {
 public:
  SmoothGroups(const TriangleMesh& mesh, const Places& places)
      : mesh_(mesh), places_(places), least_(std::cos(kCreaseDegrees * std::numbers::pi / 180)) {}

  // group[i]: the lowest place of a corner of the same group.
  const std::vector<uint32_t>& of(std::span<const uint32_t> corners) {
    group_.resize(corners.size());
    std::iota(group_.begin(), group_.end(), 0u);
    edges_.clear();
    facing_.clear();
    for (uint32_t i = 0; i < corners.size(); ++i) {
      const auto& triangle = mesh_.triangles[corners[i] / 3];
      const size_t k = corners[i] % 3;
      edges_.emplace_back(places_.of(triangle[(k + 1) % 3]), i);
      edges_.emplace_back(places_.of(triangle[(k + 2) % 3]), i);
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
  const Places& places_;
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
  const bool byTriangle = !object.triangleColours.empty(), shaded = normals != Normals::none;
  SurfacePoints points;
  if (!byTriangle) points.colours = object.vertexColours;
  if (!byTriangle && !shaded) return points;

  if (mesh.triangles.size() > UINT32_MAX / 3)
    throw Error("the model has more than " + std::to_string(UINT32_MAX / 3) + " triangles; reduce it first",
                Error::Kind::work);
  const Places places(mesh, normals == Normals::joined);
  const Corners corners(mesh, places);
  SmoothGroups groups(mesh, places);
  struct Wanted {
    uint32_t vertex, group, colour, place;  // of the corner around its place
    [[nodiscard]] auto key() const { return std::tie(vertex, group, colour, place); }
    [[nodiscard]] bool samePoint(const Wanted& o) const {
      return vertex == o.vertex && group == o.group && colour == o.colour;
    }
  };
  std::vector<Wanted> wanted;
  std::vector<Vec3d> sums;  // by group
  points.triangles.resize(mesh.triangles.size());
  // As many as most meshes need: a list that grows holds its items twice.
  points.vertex.reserve(mesh.positions.size());
  if (shaded) points.normals.reserve(mesh.positions.size());
  for (size_t p = 0; p < places.count(); ++p) {
    const std::span<const uint32_t> around = corners.around(p);
    const std::span<const uint32_t> group = shaded ? std::span(groups.of(around)) : std::span<const uint32_t>();
    wanted.clear();
    sums.assign(shaded ? around.size() : 0, Vec3d::Zero());
    for (uint32_t i = 0; i < around.size(); ++i) {
      wanted.push_back({mesh.triangles[around[i] / 3][around[i] % 3], shaded ? group[i] : 0,
                        byTriangle ? packed(object.triangleColours[around[i] / 3]) : 0, i});
      if (shaded) sums[group[i]] += weighted(mesh, around[i]);
    }
    std::sort(wanted.begin(), wanted.end(), [](const Wanted& a, const Wanted& b) { return a.key() < b.key(); });
    for (size_t i = 0; i < wanted.size(); ++i) {
      const Wanted& each = wanted[i];
      const uint32_t corner = around[each.place];
      if (i == 0 || !each.samePoint(wanted[i - 1])) {
        points.vertex.push_back(each.vertex);
        if (byTriangle) points.colours.push_back(object.triangleColours[corner / 3]);
        if (shaded) points.normals.push_back(unit(sums[each.group]));
      }
      points.triangles[corner / 3][corner % 3] = uint32_t(points.vertex.size() - 1);
    }
  }
  // Each vertex is one point, unless some belong to no triangle.
  if (points.vertex.size() == mesh.positions.size()) {
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
