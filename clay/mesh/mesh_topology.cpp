#include "clay/mesh/mesh_topology.h"

#include <algorithm>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include "clay/base/error.h"

namespace argil::clay {

namespace {

using Triangle = std::array<uint32_t, 3>;

/// Triangles whose sums are added up before they join the total: bounds the rounding error, fixes the order.
constexpr size_t kSumBlock = 4096;

bool degenerate(const Triangle& t) {
  return t[0] == t[1] || t[1] == t[2] || t[2] == t[0];
}

/// Vertices from `base` on, and triangles that use no others.
struct Window {
  std::span<const Vec3d> positions;
  std::span<const Triangle> triangles;
  uint64_t base = 0;
};

/// For each vertex of a window the triangles around it, degenerate ones left out: those of vertex base + v are
/// list[first[v]] to list[first[v + 1]].
struct Incidence {
  std::vector<uint64_t> first;
  std::vector<uint32_t> list;
};

Incidence incidence(const Window& window) {
  Incidence result;
  // Counts are kept two places up, so that filling the list moves each start to its final place.
  result.first.assign(window.positions.size() + 2, 0);
  for (const Triangle& triangle : window.triangles) {
    if (degenerate(triangle)) continue;
    for (const uint32_t v : triangle)
      if (v >= window.base) ++result.first[v - window.base + 2];
  }
  std::partial_sum(result.first.begin(), result.first.end(), result.first.begin());
  result.list.resize(result.first.back());
  for (size_t t = 0; t < window.triangles.size(); ++t) {
    if (degenerate(window.triangles[t])) continue;
    for (const uint32_t v : window.triangles[t])
      if (v >= window.base) result.list[result.first[v - window.base + 1]++] = uint32_t(t);
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

/// The fans of the window's vertices below `end`, and the box of those that are used.
void judgeFans(const Window& window, uint64_t end, TopologyReport& report) {
  const Incidence around = incidence(window);
  Link link;
  for (uint64_t v = window.base; v < end; ++v) {
    const size_t at = v - window.base;
    if (around.first[at] == around.first[at + 1]) continue;
    const Vec3d& p = window.positions[at];
    report.low = report.vertices > 0 ? report.low.cwiseMin(p).eval() : p;
    report.high = report.vertices > 0 ? report.high.cwiseMax(p).eval() : p;
    ++report.vertices;
    link.clear();
    for (uint64_t i = around.first[at]; i < around.first[at + 1]; ++i) {
      const Triangle& t = window.triangles[around.list[i]];
      const int corner = t[0] == v ? 0 : t[1] == v ? 1 : 2;
      link.addArc(t[size_t(corner + 1) % 3], t[size_t(corner + 2) % 3]);
    }
    link.judge(uint32_t(v), report);
  }
}

class Bodies {
 public:
  void grow(uint64_t vertices) {
    const size_t before = parent_.size();
    parent_.resize(vertices);
    std::iota(parent_.begin() + std::ptrdiff_t(before), parent_.end(), uint32_t(before));
  }
  void unite(const Triangle& t) {
    unite(t[0], t[1]);
    unite(t[0], t[2]);
  }
  [[nodiscard]] uint64_t count(uint64_t usedVertices) const { return usedVertices - unions_; }

 private:
  uint32_t root(uint32_t v) {
    while (parent_[v] != v) v = parent_[v] = parent_[parent_[v]];
    return v;
  }
  void unite(uint32_t a, uint32_t b) {
    a = root(a), b = root(b);
    if (a == b) return;
    // The lower index stays: meshes are mostly in order, so paths stay short.
    parent_[std::max(a, b)] = std::min(a, b);
    ++unions_;
  }

  std::vector<uint32_t> parent_;
  uint64_t unions_ = 0;
};

/// Volume and area, added up in blocks of kSumBlock triangles.
class Measure {
 public:
  void add(const Vec3d& a, const Vec3d& b, const Vec3d& c) {
    blockVolumes_ += a.dot(b.cross(c));
    blockAreas_ += (b - a).cross(c - a).norm();
  }
  /// Behind each triangle, degenerate ones too.
  void next() {
    if (++inBlock_ == kSumBlock) closeBlock();
  }
  void tell(TopologyReport& report) {
    closeBlock();
    report.volume = sixVolumes_ / 6;
    report.area = twoAreas_ / 2;
  }

 private:
  void closeBlock() {
    sixVolumes_ += std::exchange(blockVolumes_, 0);
    twoAreas_ += std::exchange(blockAreas_, 0);
    inBlock_ = 0;
  }

  double sixVolumes_ = 0, twoAreas_ = 0, blockVolumes_ = 0, blockAreas_ = 0;
  size_t inBlock_ = 0;
};

/// Counts, bodies and sums of triangles; the vertices that they name must be in the window.
void takeTriangles(const Window& window, std::span<const Triangle> triangles, const Vec3d& middle, Bodies& bodies,
                   Measure& measure, TopologyReport& report) {
  const uint64_t end = window.base + window.positions.size();
  for (const Triangle& triangle : triangles) {
    for (const uint32_t v : triangle) {
      if (v >= end || v < window.base) {
        throw Error("triangle " + std::to_string(report.triangles) + " of the mesh names vertex " + std::to_string(v) +
                        " of " + std::to_string(end) + ": the mesh is damaged",
                    Error::Kind::work);
      }
    }
    ++report.triangles;
    if (degenerate(triangle)) {
      ++report.degenerateTriangles;
    } else {
      bodies.unite(triangle);
      const auto at = [&](size_t i) -> Vec3d { return window.positions[triangle[i] - window.base] - middle; };
      measure.add(at(0), at(1), at(2));
    }
    measure.next();
  }
}

void requireCountable(uint64_t triangles, uint64_t vertices) {
  if (std::max(triangles, vertices) > UINT32_MAX) {
    throw Error("a mesh of more than 4 294 967 295 triangles or vertices cannot be checked: split it",
                Error::Kind::work);
  }
}

/// Of the vertices that some triangle uses.
Vec3d middleOf(const TriangleMesh& mesh) {
  Vec3d low = Vec3d::Zero(), high = Vec3d::Zero();
  bool any = false;
  for (const Triangle& triangle : mesh.triangles) {
    if (degenerate(triangle)) continue;
    for (const uint32_t v : triangle) {
      if (v >= mesh.positions.size()) continue;  // refused later
      const Vec3d& p = mesh.positions[v];
      low = any ? low.cwiseMin(p).eval() : p;
      high = any ? high.cwiseMax(p).eval() : p;
      any = true;
    }
  }
  return low + (high - low) / 2;
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
  requireCountable(mesh.triangles.size(), mesh.positions.size());
  TopologyReport report;
  const Window window{mesh.positions, mesh.triangles};
  Bodies bodies;
  bodies.grow(mesh.positions.size());
  Measure measure;
  takeTriangles(window, mesh.triangles, middleOf(mesh), bodies, measure, report);
  judgeFans(window, mesh.positions.size(), report);
  report.bodies = bodies.count(report.vertices);
  measure.tell(report);
  return report;
}

struct TopologyCheck::State {
  Vec3d middle = Vec3d::Zero();
  std::vector<Vec3d> positions;  // from base on
  std::vector<Triangle> triangles;
  uint64_t base = 0;
  Bodies bodies;
  Measure measure;
  TopologyReport report;
  [[nodiscard]] Window window() const { return {positions, triangles, base}; }
};

TopologyCheck::TopologyCheck(const Vec3d& middle) : state_(std::make_unique<State>()) {
  state_->middle = middle;
}
TopologyCheck::~TopologyCheck() = default;

void TopologyCheck::add(std::span<const Vec3d> positions, std::span<const Triangle> triangles) {
  State& s = *state_;
  requireCountable(s.report.triangles + triangles.size(), s.base + s.positions.size() + positions.size());
  s.positions.insert(s.positions.end(), positions.begin(), positions.end());
  s.bodies.grow(s.base + s.positions.size());
  takeTriangles(s.window(), triangles, s.middle, s.bodies, s.measure, s.report);
  s.triangles.insert(s.triangles.end(), triangles.begin(), triangles.end());
}

void TopologyCheck::settle(uint64_t vertices) {
  State& s = *state_;
  const uint64_t end = std::min<uint64_t>(vertices, s.base + s.positions.size());
  if (end <= s.base) return;
  judgeFans(s.window(), end, s.report);
  s.positions.erase(s.positions.begin(), s.positions.begin() + std::ptrdiff_t(end - s.base));
  s.base = end;
  std::erase_if(s.triangles, [&](const Triangle& t) { return std::max({t[0], t[1], t[2]}) < end; });
}

TopologyReport TopologyCheck::finish() {
  State& s = *state_;
  settle(s.base + s.positions.size());
  s.report.bodies = s.bodies.count(s.report.vertices);
  s.measure.tell(s.report);
  return s.report;
}

}  // namespace argil::clay
