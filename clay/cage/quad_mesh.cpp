#include "clay/cage/quad_mesh.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "clay/base/error.h"

namespace argil::clay {

QuadTopology::QuadTopology(size_t vertices, std::vector<std::array<uint32_t, 4>> quads,
                           const std::vector<uint8_t>& creases)
    : quads_(std::move(quads)), edgesOf_(quads_.size()) {
  constexpr const char* kOpen = "a mesh of quads that is not closed: each side needs one quad on its other side";
  const auto key = [](uint32_t a, uint32_t b) { return uint64_t{a} << 32 | b; };
  std::unordered_map<uint64_t, std::pair<uint32_t, uint8_t>> sides;
  for (uint32_t f = 0; f < quads_.size(); ++f)
    for (uint8_t s = 0; s < 4; ++s) {
      const uint32_t a = quads_[f][s], b = quads_[f][(s + 1) & 3];
      if (a >= vertices || a == b || !sides.emplace(key(a, b), std::pair{f, s}).second) throw Error(kOpen);
    }
  for (uint32_t f = 0; f < quads_.size(); ++f)
    for (uint8_t s = 0; s < 4; ++s) {
      const uint32_t a = quads_[f][s], b = quads_[f][(s + 1) & 3];
      const auto other = sides.find(key(b, a));
      if (other == sides.end()) throw Error(kOpen);
      if (a > b) continue;
      const auto [quad, side] = other->second;
      edgesOf_[f][s] = edgesOf_[quad][side] = static_cast<uint32_t>(edges_.size());
      const bool crease = !creases.empty() && (creases[f] >> s & 1) != 0;
      if (!creases.empty() && crease != ((creases[quad] >> side & 1) != 0)) throw Error("a crease with one side");
      edges_.push_back({a, b, {f, quad}, {s, side}, crease});
    }

  std::vector<std::pair<uint32_t, uint8_t>> any(vertices, {UINT32_MAX, 0});
  std::vector<size_t> count(vertices, 0);
  for (uint32_t f = 0; f < quads_.size(); ++f)
    for (uint8_t s = 0; s < 4; ++s) any[quads_[f][s]] = {f, s}, ++count[quads_[f][s]];
  for (uint32_t v = 0; v < vertices; ++v) {
    first_.push_back(spokes_.size());
    if (count[v] < 3) throw Error("a mesh of quads with a vertex of fewer than three");
    auto [quad, corner] = any[v];
    for (size_t k = 0; k < count[v]; ++k) {
      const uint32_t edge = edgesOf_[quad][corner];
      spokes_.push_back({quad, corner, edge, edges_[edge].from == v});
      // The next one has the side before as the one that leaves the vertex.
      const Edge& before = edges_[edgesOf_[quad][(corner + 3) & 3]];
      const size_t other = before.quad[0] == quad && before.side[0] == ((corner + 3) & 3) ? 1 : 0;
      quad = before.quad[other];
      corner = before.side[other];
    }
    if (std::pair{quad, corner} != any[v]) throw Error("a mesh of quads with a vertex where two parts meet");
  }
  first_.push_back(spokes_.size());
}

size_t QuadTopology::creasesAt(uint32_t vertex) const {
  size_t count = 0;
  for (size_t k = 0; k < valence(vertex); ++k) count += edges_[spokes(vertex)[k].edge].crease;
  return count;
}

size_t QuadTopology::irregular() const {
  size_t count = 0;
  for (uint32_t v = 0; v < vertexCount(); ++v) {
    const size_t creases = creasesAt(v);
    count += valence(v) != 4 && (creases == 0 || creases == 2);
  }
  return count;
}

std::array<std::array<uint8_t, 3>, 2> trianglesOf(const std::array<Vec3d, 4>& c) {
  const auto least = [&](size_t first) {  // the smaller share of the quad's area, seen from its middle
    const Vec3d normal = (c[2] - c[0]).cross(c[3] - c[1]);
    const auto at = [&](size_t i) -> const Vec3d& { return c[(first + i) & 3]; };
    return std::min((at(1) - at(0)).cross(at(2) - at(0)).dot(normal), (at(2) - at(0)).cross(at(3) - at(0)).dot(normal));
  };
  const bool shorter = (c[2] - c[0]).squaredNorm() <= (c[3] - c[1]).squaredNorm();
  const double first = least(0), second = least(1);
  const bool along02 = shorter ? first > 0 || first >= second : !(second > 0 || second >= first);
  if (along02) return {{{0, 1, 2}, {0, 2, 3}}};
  return {{{1, 2, 3}, {1, 3, 0}}};
}

TriangleMesh trianglesOf(const QuadMesh& mesh) {
  TriangleMesh out;
  out.positions = mesh.positions;
  for (const auto& q : mesh.quads)
    for (const auto& t :
         trianglesOf({mesh.positions[q[0]], mesh.positions[q[1]], mesh.positions[q[2]], mesh.positions[q[3]]}))
      out.triangles.push_back({q[t[0]], q[t[1]], q[t[2]]});
  return out;
}

double scaledJacobian(const QuadMesh& mesh, const std::array<uint32_t, 4>& quad) {
  std::array<Vec3d, 4> p;
  for (size_t s = 0; s < 4; ++s) p[s] = mesh.positions[quad[s]];
  const Vec3d normal = (p[2] - p[0]).cross(p[3] - p[1]).normalized();
  double least = 1;
  for (size_t s = 0; s < 4; ++s) {
    const Vec3d next = p[(s + 1) & 3] - p[s], last = p[(s + 3) & 3] - p[s];
    const double lengths = next.norm() * last.norm();
    least = std::min(least, lengths > 0 ? next.cross(last).dot(normal) / lengths : 0);
  }
  return least;
}

QuadShapes shapesOf(const QuadMesh& mesh) {
  QuadShapes out;
  double sum = 0;
  for (const auto& quad : mesh.quads) {
    const double jacobian = scaledJacobian(mesh, quad);
    sum += jacobian;
    out.least = std::min(out.least, jacobian);
  }
  if (!mesh.quads.empty()) out.mean = sum / double(mesh.quads.size());
  return out;
}

QuadMesh halved(const QuadMesh& mesh) {
  const QuadTopology topology(mesh);
  QuadMesh out;
  out.positions = mesh.positions;
  out.corners = mesh.corners;
  const auto firstMiddle = static_cast<uint32_t>(out.positions.size());
  for (const QuadTopology::Edge& each : topology.edges())
    out.positions.push_back(0.5 * (mesh.positions[each.from] + mesh.positions[each.to]));
  out.quads.reserve(4 * mesh.quads.size());
  for (uint32_t f = 0; f < mesh.quads.size(); ++f) {
    const auto& q = mesh.quads[f];
    const auto middle = static_cast<uint32_t>(out.positions.size());
    out.positions.push_back(
        0.25 * (mesh.positions[q[0]] + mesh.positions[q[1]] + mesh.positions[q[2]] + mesh.positions[q[3]]));
    for (int s = 0; s < 4; ++s) {
      const int last = (s + 3) & 3;
      out.quads.push_back(
          {q[size_t(s)], firstMiddle + topology.edgeOf(f, s), middle, firstMiddle + topology.edgeOf(f, last)});
      if (mesh.creases.empty()) continue;
      const int bits = mesh.creases[f];
      out.creases.push_back(static_cast<uint8_t>((bits >> s & 1) | (bits >> last & 1) << 3));
    }
  }
  return out;
}

}  // namespace argil::clay
