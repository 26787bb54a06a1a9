#include "clay/mesh/mesh_topology.h"

#include <algorithm>
#include <numeric>
#include <string>

#include "clay/base/error.h"

namespace argil::clay {

namespace {

using Triangle = std::array<uint32_t, 3>;

/// Triangles whose sums are added up before they join the total: bounds the rounding error, fixes the order.
constexpr size_t kSumBlock = 4096;

bool degenerate(const Triangle& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

/// For each vertex the triangles around it, degenerate ones left out: those of v are list[first[v]] to list[first[v +
/// 1]].
struct Incidence {
  std::vector<uint64_t> first;
  std::vector<uint32_t> list;
};

Incidence incidence(const TriangleMesh& mesh, TopologyReport& report) {
  Incidence result;
  const size_t vertexCount = mesh.positions.size();
  if (std::max(mesh.triangles.size(), vertexCount) > UINT32_MAX) {
    throw Error("a mesh of more than 4 294 967 295 triangles or vertices cannot be checked: split it",
                Error::Kind::work);
  }
  // Counts are kept two places up, so that filling the list moves each start to its final place.
  result.first.assign(vertexCount + 2, 0);
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Triangle& triangle = mesh.triangles[t];
    for (const uint32_t v : triangle) {
      if (v >= vertexCount) {
        throw Error("triangle " + std::to_string(t) + " of the mesh names vertex " + std::to_string(v) + " of " +
                        std::to_string(vertexCount) + ": the mesh is damaged",
                    Error::Kind::work);
      }
    }
    if (degenerate(triangle)) {
      ++report.degenerateTriangles;
      continue;
    }
    for (const uint32_t v : triangle) ++result.first[v + 2];
  }
  std::partial_sum(result.first.begin(), result.first.end(), result.first.begin());
  result.list.resize(result.first.back());
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    if (degenerate(mesh.triangles[t])) continue;
    for (const uint32_t v : mesh.triangles[t]) result.list[result.first[v + 1]++] = uint32_t(t);
  }
  result.first.pop_back();
  return result;
}

/// The triangles around one vertex, read as a graph on the neighbouring vertices. Reused from vertex to vertex.
class Link {
 public:
  void clear() { ends_.clear(), arcs_ = 0; }

  /// The triangle (v, from, to).
  void addArc(uint32_t from, uint32_t to) {
    ends_.push_back({from, arcs_, true});
    ends_.push_back({to, arcs_, false});
    ++arcs_;
  }

  /// Adds what the fan of `vertex`, and the edges from it to higher vertices, have to say.
  void judge(uint32_t vertex, TopologyReport& report) {
    std::sort(ends_.begin(), ends_.end(), [](const End& a, const End& b) { return a.neighbour < b.neighbour; });
    parent_.resize(arcs_);
    std::iota(parent_.begin(), parent_.end(), 0u);
    uint32_t parts = arcs_;
    uint32_t loose = 0;
    bool branches = false;
    for (size_t i = 0; i < ends_.size();) {
      size_t next = i;
      uint32_t outgoing = 0;
      for (; next < ends_.size() && ends_[next].neighbour == ends_[i].neighbour; ++next) {
        outgoing += ends_[next].outgoing ? 1 : 0;
        parts -= unite(ends_[i].arc, ends_[next].arc);
      }
      const size_t uses = next - i;
      loose += uses == 1;
      branches |= uses > 2;
      if (ends_[i].neighbour > vertex) {
        report.boundaryEdges += uses == 1;
        report.nonManifoldEdges += uses > 2;
        report.flippedEdges += uses == 2 && outgoing != 1;
      }
      i = next;
    }
    if (branches || parts != 1) {
      ++report.nonManifoldVertices;
    } else if (loose != 0) {
      ++report.boundaryVertices;
    }
  }

 private:
  struct End {
    uint32_t neighbour;
    uint32_t arc;
    bool outgoing;
  };

  uint32_t root(uint32_t arc) {
    while (parent_[arc] != arc) arc = parent_[arc] = parent_[parent_[arc]];
    return arc;
  }

  /// 1 when two parts became one.
  uint32_t unite(uint32_t a, uint32_t b) {
    a = root(a), b = root(b);
    parent_[a] = b;
    return a != b;
  }

  std::vector<End> ends_;
  std::vector<uint32_t> parent_;
  uint32_t arcs_ = 0;
};

void judgeFans(const TriangleMesh& mesh, const Incidence& around, TopologyReport& report) {
  Link link;
  const auto vertexCount = uint32_t(mesh.positions.size());
  for (uint32_t v = 0; v < vertexCount; ++v) {
    if (around.first[v] == around.first[v + 1]) continue;
    ++report.vertices;
    link.clear();
    for (uint64_t i = around.first[v]; i < around.first[v + 1]; ++i) {
      const Triangle& t = mesh.triangles[around.list[i]];
      const int corner = t[0] == v ? 0 : t[1] == v ? 1 : 2;
      link.addArc(t[size_t(corner + 1) % 3], t[size_t(corner + 2) % 3]);
    }
    link.judge(v, report);
  }
}

uint64_t countBodies(const TriangleMesh& mesh, uint64_t usedVertices) {
  std::vector<uint32_t> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto root = [&](uint32_t v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  uint64_t bodies = usedVertices;
  const auto unite = [&](uint32_t a, uint32_t b) {
    a = root(a), b = root(b);
    if (a == b) return;
    // The lower index stays: meshes are mostly in order, so paths stay short.
    parent[std::max(a, b)] = std::min(a, b);
    --bodies;
  };
  for (const Triangle& t : mesh.triangles) {
    if (degenerate(t)) continue;
    unite(t[0], t[1]);
    unite(t[0], t[2]);
  }
  return bodies;
}

void measure(const TriangleMesh& mesh, const Incidence& around, TopologyReport& report) {
  bool any = false;
  for (size_t v = 0; v < mesh.positions.size(); ++v) {
    if (around.first[v] == around.first[v + 1]) continue;
    const Vec3d& p = mesh.positions[v];
    report.low = any ? report.low.cwiseMin(p).eval() : p;
    report.high = any ? report.high.cwiseMax(p).eval() : p;
    any = true;
  }
  const Vec3d middle = report.low + (report.high - report.low) / 2;
  double sixVolumes = 0;
  double twoAreas = 0;
  for (size_t begin = 0; begin < mesh.triangles.size(); begin += kSumBlock) {
    const size_t end = std::min(begin + kSumBlock, mesh.triangles.size());
    double blockVolumes = 0;
    double blockAreas = 0;
    for (size_t t = begin; t < end; ++t) {
      const Triangle& triangle = mesh.triangles[t];
      if (degenerate(triangle)) continue;
      const Vec3d a = mesh.positions[triangle[0]] - middle;
      const Vec3d b = mesh.positions[triangle[1]] - middle;
      const Vec3d c = mesh.positions[triangle[2]] - middle;
      blockVolumes += a.dot(b.cross(c));
      blockAreas += (b - a).cross(c - a).norm();
    }
    sixVolumes += blockVolumes;
    twoAreas += blockAreas;
  }
  report.volume = sixVolumes / 6;
  report.area = twoAreas / 2;
}

}  // namespace

bool TopologyReport::closed() const {
  return degenerateTriangles == 0 && solid();
}

bool TopologyReport::solid() const {
  return triangles > degenerateTriangles && boundaryEdges == 0 && nonManifoldEdges == 0 && flippedEdges == 0 &&
         boundaryVertices == 0 && nonManifoldVertices == 0;
}

TopologyReport checkTopology(const TriangleMesh& mesh) {
  TopologyReport report;
  report.triangles = mesh.triangles.size();
  const Incidence around = incidence(mesh, report);
  judgeFans(mesh, around, report);
  report.bodies = countBodies(mesh, report.vertices);
  measure(mesh, around, report);
  return report;
}

}  // namespace argil::clay
