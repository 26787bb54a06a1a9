#include "clay/cage/crease_map.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <numeric>
#include <set>
#include <unordered_map>
#include <utility>

namespace argil::clay {

namespace {

constexpr double kNear = 0.75;       // of an edge: so near to a crease of the clay it may be one
constexpr double kMostlyBent = 0.6;  // of the border of two faces: less, and they are one
constexpr uint32_t kFewQuads = 4;    // of a face: fewer belong to the one beside them
constexpr int kCornerPieces = 4;     // of a line, over which a turn is seen
constexpr double kCornerTurn = 0.7;  // radians
constexpr double kStripWidth = 1.6;  // edges: what is narrower is no face
constexpr int kTeeth = 3;            // rounds that take teeth from borders

const double kLeastCosine = std::cos(kCreaseDegrees / 180 * std::numbers::pi);

class Joined {
 public:
  explicit Joined(size_t count) : root_(count) { std::iota(root_.begin(), root_.end(), 0u); }
  uint32_t find(uint32_t v) {
    while (root_[v] != v) v = root_[v] = root_[root_[v]];
    return v;
  }
  // The lower number stays.
  void join(uint32_t a, uint32_t b) {
    a = find(a), b = find(b);
    if (a != b) root_[std::max(a, b)] = std::min(a, b);
  }

 private:
  std::vector<uint32_t> root_;
};

// The border of two faces.
struct Border {
  double length = 0, bent = 0;
};

class Faces {
 public:
  Faces(const QuadTopology& topology, const std::vector<Vec3d>& positions, const std::vector<bool>& bent)
      : topology_(topology), positions_(positions), bent_(bent), face_(topology.quads().size(), kNone) {}

  std::vector<uint32_t> run() {
    // Faces begin where no crease is near, so that two that meet through a gap of a crease stay two.
    std::vector<bool> nearBent(positions_.size());
    for (size_t e = 0; e < bent_.size(); ++e)
      if (bent_[e]) nearBent[topology_.edges()[e].from] = nearBent[topology_.edges()[e].to] = true;
    const auto away = [&](uint32_t f) {
      const auto& q = topology_.quads()[f];
      return std::none_of(q.begin(), q.end(), [&](uint32_t v) { return nearBent[v]; });
    };
    std::vector<uint32_t> all;
    for (uint32_t f = 0; f < face_.size(); ++f)
      if (face_[f] == kNone && away(f)) flood(f, away, all);
    grow(std::move(all));
    const auto any = [](uint32_t) { return true; };
    for (uint32_t f = 0; f < face_.size(); ++f) {
      if (face_[f] != kNone) continue;
      all.clear();
      flood(f, any, all);
      if (isStrip(all)) strips_.insert(f);
    }
    joinFaces();
    for (int round = 0; round < kTeeth; ++round) takeTeeth();
    return face_;
  }

 private:
  static constexpr uint32_t kNone = UINT32_MAX;

  template <class Visit>
  void beside(uint32_t f, const Visit& visit) const {
    for (int s = 0; s < 4; ++s) {
      const uint32_t e = topology_.edgeOf(f, s);
      const auto& quad = topology_.edges()[e].quad;
      visit(e, quad[0] == f ? quad[1] : quad[0]);
    }
  }
  template <class May>
  void flood(uint32_t first, const May& may, std::vector<uint32_t>& all) {
    std::vector<uint32_t> todo{first};
    face_[first] = first;
    while (!todo.empty()) {
      const uint32_t f = todo.back();
      todo.pop_back();
      all.push_back(f);
      beside(f, [&](uint32_t e, uint32_t next) {
        if (bent_[e] || face_[next] != kNone || !may(next)) return;
        face_[next] = first;
        todo.push_back(next);
      });
    }
  }
  // All of them outwards by one quad at a time.
  void grow(std::vector<uint32_t> front) {
    std::vector<uint32_t> next;
    for (; !front.empty(); front.swap(next), next.clear())
      for (const uint32_t f : front)
        beside(f, [&](uint32_t e, uint32_t other) {
          if (bent_[e] || face_[other] != kNone) return;
          face_[other] = face_[f];
          next.push_back(other);
        });
  }
  double lengthOf(size_t e) const {
    return (positions_[topology_.edges()[e].from] - positions_[topology_.edges()[e].to]).norm();
  }
  // Quads that lie across a crease, one beside the other: no face of its own.
  bool isStrip(const std::vector<uint32_t>& quads) const {
    double border = 0, area = 0, edges = 0;
    for (const uint32_t f : quads) {
      const auto& q = topology_.quads()[f];
      area += 0.5 * (positions_[q[2]] - positions_[q[0]]).cross(positions_[q[3]] - positions_[q[1]]).norm();
      beside(f, [&](uint32_t e, uint32_t next) {
        edges += lengthOf(e);
        if (face_[next] != face_[f]) border += lengthOf(e);
      });
    }
    return area < kStripWidth * border / 2 * edges / (4 * double(quads.size()));
  }
  // Faces whose border is no crease, and small ones with what they share the longest border with.
  void joinFaces() {
    for (bool again = true; again;) {
      again = false;
      std::map<std::pair<uint32_t, uint32_t>, Border> borders;
      std::unordered_map<uint32_t, uint32_t> sizes;
      for (const uint32_t face : face_) ++sizes[face];
      for (size_t e = 0; e < bent_.size(); ++e) {
        const auto& quad = topology_.edges()[e].quad;
        const uint32_t a = face_[quad[0]], b = face_[quad[1]];
        if (a == b) continue;
        Border& border = borders[std::minmax(a, b)];
        border.length += lengthOf(e);
        border.bent += bent_[e] ? lengthOf(e) : 0;
      }
      Joined joined(face_.size());
      std::unordered_map<uint32_t, std::pair<double, uint32_t>> longest;
      for (const auto& [faces, border] : borders) {
        if (border.bent < kMostlyBent * border.length) joined.join(faces.first, faces.second), again = true;
        for (const auto& [own, other] : {faces, std::pair{faces.second, faces.first}})
          if ((sizes[own] < kFewQuads || strips_.count(own) != 0) && border.length > longest[own].first)
            longest[own] = {border.length, other};
      }
      for (const auto& [own, most] : longest) joined.join(own, most.second), again = true;
      strips_.clear();
      for (uint32_t& face : face_) face = joined.find(face);
    }
  }
  // A quad with three sides in another face.
  void takeTeeth() {
    for (uint32_t f = 0; f < face_.size(); ++f) {
      std::array<uint32_t, 4> others{};
      size_t count = 0;
      beside(f, [&](uint32_t, uint32_t other) { others[count++] = face_[other]; });
      for (const uint32_t other : others)
        if (other != face_[f] && std::count(others.begin(), others.end(), other) >= 3) {
          face_[f] = other;
          break;
        }
    }
  }

  const QuadTopology& topology_;
  const std::vector<Vec3d>& positions_;
  const std::vector<bool>& bent_;
  std::vector<uint32_t> face_;
  std::set<uint32_t> strips_;
};

Vec3d normalOf(const QuadMesh& mesh, uint32_t quad) {
  const auto& q = mesh.quads[quad];
  return (mesh.positions[q[2]] - mesh.positions[q[0]]).cross(mesh.positions[q[3]] - mesh.positions[q[1]]).normalized();
}

}  // namespace

CreaseMap::CreaseMap(const Surface& fine, double leastMm) {
  const TriangleMesh mesh = fine.toMesh();
  std::vector<bool> sharp;
  sharp.reserve(mesh.positions.size());
  fine.forEach([&](const BrickMesh& brick) {
    for (const PackedNormal& each : brick.normals) sharp.push_back((each.v & 1) != 0);
  });
  sharp.resize(mesh.positions.size(), false);
  // Sides between two sharp vertices, and the triangle on their one side.
  std::unordered_map<uint64_t, uint32_t> sides;
  const auto normal = [&](uint32_t t) {
    const auto& c = mesh.triangles[t];
    return (mesh.positions[c[1]] - mesh.positions[c[0]]).cross(mesh.positions[c[2]] - mesh.positions[c[0]]);
  };
  std::vector<std::array<uint32_t, 2>> found;
  for (uint32_t t = 0; t < mesh.triangles.size(); ++t)
    for (size_t s = 0; s < 3; ++s) {
      const uint32_t a = mesh.triangles[t][s], b = mesh.triangles[t][(s + 1) % 3];
      if (!sharp[a] || !sharp[b]) continue;
      const auto [it, isNew] = sides.try_emplace(uint64_t{std::min(a, b)} << 32 | std::max(a, b), t);
      if (isNew) continue;
      const Vec3d n = normal(it->second), m = normal(t);
      if (n.dot(m) < kLeastCosine * n.norm() * m.norm()) found.push_back({a, b});
    }
  Joined lines(mesh.positions.size());
  std::unordered_map<uint32_t, double> lengths;
  for (const auto& [a, b] : found) lines.join(a, b);
  for (const auto& [a, b] : found) lengths[lines.find(a)] += (mesh.positions[a] - mesh.positions[b]).norm();
  std::unordered_map<uint32_t, uint32_t> index;
  const auto indexOf = [&](uint32_t v) {
    const auto [it, isNew] = index.try_emplace(v, static_cast<uint32_t>(pieces_.positions.size()));
    if (isNew) pieces_.positions.push_back(mesh.positions[v]);
    return it->second;
  };
  for (const auto& [a, b] : found) {
    if (lengths[lines.find(a)] < leastMm) continue;
    const uint32_t from = indexOf(a), to = indexOf(b);
    pieces_.triangles.push_back({from, to, to});
  }
  if (empty()) return;
  tree_ = std::make_unique<NearestTriangle>(pieces_);
  findCorners();
}

void CreaseMap::findCorners() {
  std::vector<std::vector<uint32_t>> beside(pieces_.positions.size());
  for (const auto& piece : pieces_.triangles) {
    beside[piece[0]].push_back(piece[1]);
    beside[piece[1]].push_back(piece[0]);
  }
  // Over some pieces either way, so that a place that lies beside its line is none.
  std::vector<double> turn(beside.size(), 0);
  const auto walk = [&](uint32_t from, uint32_t to, const auto& visit) {
    for (int i = 0; i < kCornerPieces; ++i) {
      visit(to);
      if (beside[to].size() != 2) break;
      from = std::exchange(to, beside[to][0] == from ? beside[to][1] : beside[to][0]);
    }
  };
  for (uint32_t v = 0; v < beside.size(); ++v) {
    if (beside[v].size() != 2) {
      corners_.push_back(pieces_.positions[v]);
      continue;
    }
    std::array<Vec3d, 2> ways;
    for (size_t k = 0; k < 2; ++k)
      walk(v, beside[v][k], [&](uint32_t at) { ways[k] = pieces_.positions[at] - pieces_.positions[v]; });
    turn[v] = std::numbers::pi - std::atan2(ways[0].cross(ways[1]).norm(), ways[0].dot(ways[1]));
  }
  for (uint32_t v = 0; v < beside.size(); ++v) {
    if (turn[v] < kCornerTurn) continue;
    bool most = true;
    for (const uint32_t next : beside[v])
      walk(v, next, [&](uint32_t at) { most = most && (turn[at] < turn[v] || (turn[at] == turn[v] && at >= v)); });
    if (most) corners_.push_back(pieces_.positions[v]);
  }
}

std::optional<uint32_t> CreaseMap::cornerNear(const Vec3d& mm, double most, const std::set<uint32_t>& but) const {
  std::optional<uint32_t> best;
  for (uint32_t i = 0; i < corners_.size(); ++i)
    if (const double away = (corners_[i] - mm).norm(); away <= most && but.count(i) == 0) best = i, most = away;
  return best;
}

CreaseMap::Hit CreaseMap::nearest(const Vec3d& mm, uint32_t& hint) const {
  Hit out;
  if (empty()) return out;
  const NearestTriangle::Hit hit = tree_->nearest(mm, hint);
  hint = hit.triangle;
  const auto& c = tree_->corners(hit.triangle);
  const Vec3d &a = pieces_.positions[c[0]], &b = pieces_.positions[c[1]];
  out.mm = nearestOnTriangle(mm, a, b, b);
  out.squared = hit.squared;
  if ((b - a).squaredNorm() > 0) out.along = (b - a).normalized();
  return out;
}

void CreaseMap::mark(QuadMesh& mesh) const {
  mesh.creases.assign(mesh.quads.size(), 0);
  if (empty()) return;
  const QuadTopology topology(mesh.positions.size(), mesh.quads);
  std::vector<bool> bent(topology.edges().size());
  uint32_t hint = UINT32_MAX;
  for (size_t e = 0; e < bent.size(); ++e) {
    const QuadTopology::Edge& edge = topology.edges()[e];
    if (normalOf(mesh, edge.quad[0]).dot(normalOf(mesh, edge.quad[1])) > kLeastCosine) continue;
    const Vec3d &from = mesh.positions[edge.from], &to = mesh.positions[edge.to];
    const double near = kNear * (from - to).norm();
    bent[e] = nearest(0.5 * (from + to), hint).squared < near * near;
  }
  const std::vector<uint32_t> face = Faces(topology, mesh.positions, bent).run();
  for (const QuadTopology::Edge& edge : topology.edges())
    if (face[edge.quad[0]] != face[edge.quad[1]])
      for (size_t k = 0; k < 2; ++k)
        mesh.creases[edge.quad[k]] = static_cast<uint8_t>(mesh.creases[edge.quad[k]] | 1 << edge.side[k]);
}

}  // namespace argil::clay
