#include "clay/cage/patch_deviation.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

#include "clay/base/parallel.h"
#include "clay/mesh/nearest_triangle.h"

namespace argil::clay {

namespace {

constexpr int kBlock = 256;
// Of what is around a place: a triangle that is less has no side. So has the last one in a corner of half a turn.
constexpr double kFold = 0.005;
constexpr double kSliver = 0.1;  // twice the area around a place by the square of a side

OneWay summed(std::vector<double> squared, const std::vector<Vec3d>& places) {
  OneWay way;
  way.points = squared.size();
  if (squared.empty()) return way;
  const auto most = std::max_element(squared.begin(), squared.end());
  way.worstMm = places[size_t(most - squared.begin())];
  way.max = std::sqrt(*most);
  for (const double each : squared) way.rms += each / double(squared.size());
  way.rms = std::sqrt(way.rms);
  const auto at = squared.begin() + std::ptrdiff_t(0.99 * double(squared.size() - 1));
  std::nth_element(squared.begin(), at, squared.end());
  way.p99 = std::sqrt(*at);
  return way;
}

std::vector<double> squaresFrom(const std::vector<Vec3d>& from, const TriangleMesh& to, int threads) {
  const NearestTriangle tree(to);
  std::vector<double> squared(from.size());
  parallelBlocks(
      from.size(), threads,
      [&](size_t begin, size_t end) {
        uint32_t hint = UINT32_MAX;
        for (size_t i = begin; i < end; ++i) {
          const NearestTriangle::Hit hit = tree.nearest(from[i], hint);
          hint = hit.triangle;
          squared[i] = hit.squared;
        }
      },
      kBlock);
  return squared;
}

using Far = std::vector<PatchDeviation::Place>;

void addFar(const std::vector<Vec3d>& places, const std::vector<double>& squared, double limitMm, Far& far) {
  for (size_t i = 0; i < places.size(); ++i)
    if (squared[i] > limitMm * limitMm) far.push_back({places[i], std::sqrt(squared[i])});
}

// Of places that lie near one another the farthest.
Far thinned(Far far, double apartMm) {
  std::stable_sort(far.begin(), far.end(), [](const auto& a, const auto& b) { return a.offMm > b.offMm; });
  Far kept;
  for (const PatchDeviation::Place& each : far) {
    if (kept.size() == kMostFarPlaces) break;
    if (std::all_of(kept.begin(), kept.end(), [&](const auto& k) { return (k.mm - each.mm).norm() > apartMm; }))
      kept.push_back(each);
  }
  return kept;
}

Vec3d areaOf(const TriangleMesh& mesh, const std::array<uint32_t, 3>& t) {
  return (mesh.positions[t[1]] - mesh.positions[t[0]]).cross(mesh.positions[t[2]] - mesh.positions[t[0]]);
}

// Normals at the vertices of meshOf(), not of length one: the sum of what is around each, on creases of the same patch.
class PatchNormals {
 public:
  explicit PatchNormals(const TriangleMesh& mesh) : mesh_(mesh), onCrease_(mesh.positions.size()) { sum(); }
  PatchNormals(const PatchSurface& surface, const TriangleMesh& mesh, int perSpan)
      : mesh_(mesh),
        perPatch_(2 * size_t(kPatchSpans * perSpan) * size_t(kPatchSpans * perSpan)),
        onCrease_(mesh.positions.size()) {
    const QuadTopology topology(surface.cage);
    // As meshOf() numbers them: corners, then those between along each edge.
    const auto between = size_t(kPatchSpans * perSpan - 1);
    for (size_t e = 0; e < topology.edges().size(); ++e) {
      const QuadTopology::Edge& edge = topology.edges()[e];
      if (!edge.crease) continue;
      onCrease_[edge.from] = onCrease_[edge.to] = true;
      for (size_t i = 0; i < between; ++i) onCrease_[topology.vertexCount() + e * between + i] = true;
    }
    sum();
  }
  // At a corner of a triangle.
  [[nodiscard]] const Vec3d& at(size_t triangle, size_t corner) const {
    const uint32_t v = mesh_.triangles[triangle][corner];
    return onCrease_[v] ? ofPatch_.at(key(triangle, v)) : sums_[v];
  }
  // The same, but where all that is around it is a sliver, as in a corner of half a turn: that of the triangle's other
  // corners which says most.
  [[nodiscard]] const Vec3d& clearAt(size_t triangle, size_t corner) const {
    const auto& t = mesh_.triangles[triangle];
    const Vec3d& own = at(triangle, corner);
    const double side = (mesh_.positions[t[(corner + 1) % 3]] - mesh_.positions[t[corner]]).squaredNorm();
    if (own.norm() > kSliver * side) return own;
    const Vec3d &next = at(triangle, (corner + 1) % 3), &last = at(triangle, (corner + 2) % 3);
    return next.squaredNorm() > last.squaredNorm() ? next : last;
  }

 private:
  void sum() {
    sums_.resize(mesh_.positions.size(), Vec3d::Zero());
    for (size_t t = 0; t < mesh_.triangles.size(); ++t) {
      const Vec3d area = areaOf(mesh_, mesh_.triangles[t]);
      for (const uint32_t v : mesh_.triangles[t]) (onCrease_[v] ? ofPatch_[key(t, v)] : sums_[v]) += area;
    }
  }
  [[nodiscard]] uint64_t key(size_t triangle, uint32_t vertex) const {
    return uint64_t{triangle / perPatch_} << 32 | vertex;
  }
  struct Zero : Vec3d {
    Zero() : Vec3d(Vec3d::Zero()) {}
  };
  const TriangleMesh& mesh_;
  size_t perPatch_ = 1;
  std::vector<bool> onCrease_;
  std::vector<Vec3d> sums_;
  std::unordered_map<uint64_t, Zero> ofPatch_;
};

std::vector<uint32_t> foldsOf(const TriangleMesh& mesh, const PatchNormals& normals) {
  std::vector<uint32_t> folds;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const Vec3d area = areaOf(mesh, mesh.triangles[t]);
    for (size_t s = 0; s < 3; ++s)
      if (area.dot(normals.at(t, s)) < -kFold * normals.at(t, s).squaredNorm()) folds.push_back(mesh.triangles[t][s]);
  }
  std::sort(folds.begin(), folds.end());
  folds.erase(std::unique(folds.begin(), folds.end()), folds.end());
  return folds;
}

}  // namespace

std::vector<uint32_t> foldsOf(const TriangleMesh& mesh) {
  return foldsOf(mesh, PatchNormals(mesh));
}
std::vector<uint32_t> foldsOf(const PatchSurface& surface, const TriangleMesh& mesh, int perSpan) {
  return foldsOf(mesh, PatchNormals(surface, mesh, perSpan));
}

TriangleMesh meshOf(const PatchSurface& surface, int perSpan) {
  TriangleMesh mesh;
  const int side = kPatchSpans * perSpan;
  const double step = 1.0 / perSpan;
  // Places of sides are those of both quads, to the last bits: welded by what they are numbered by.
  const QuadTopology topology(surface.cage);
  const auto corners = static_cast<uint32_t>(surface.cage.positions.size());
  const auto edges = static_cast<uint32_t>(topology.edges().size());
  const auto perEdge = static_cast<uint32_t>(side - 1);
  mesh.positions.resize(corners + size_t{edges} * perEdge + topology.quads().size() * size_t{perEdge} * perEdge);
  std::vector<uint32_t> grid(size_t(side + 1) * size_t(side + 1));
  const auto index = [&](int i, int j) -> uint32_t& { return grid[size_t(i) * size_t(side + 1) + size_t(j)]; };
  for (uint32_t f = 0; f < topology.quads().size(); ++f) {
    for (int i = 1; i < side; ++i)
      for (int j = 1; j < side; ++j)
        index(i, j) = corners + edges * perEdge + f * perEdge * perEdge + uint32_t((i - 1) * (side - 1) + j - 1);
    for (int s = 0; s < 4; ++s) {
      const QuadTopology::Edge& edge = topology.edges()[topology.edgeOf(f, s)];
      const bool forward = edge.quad[0] == f && edge.side[0] == s;
      const auto [x, y] = fromCorner(s, 0, 0, side + 1);
      index(x, y) = topology.quads()[f][size_t(s)];
      for (int p = 1; p < side; ++p) {
        const auto [i, j] = fromCorner(s, p, 0, side + 1);
        index(i, j) = corners + topology.edgeOf(f, s) * perEdge + uint32_t(forward ? p - 1 : side - 1 - p);
      }
    }
    for (int i = 0; i <= side; ++i)
      for (int j = 0; j <= side; ++j) mesh.positions[index(i, j)] = surface.at(f, i * step, j * step);
    for (int i = 0; i < side; ++i)
      for (int j = 0; j < side; ++j) {
        const uint32_t a = index(i, j), b = index(i + 1, j), c = index(i + 1, j + 1), d = index(i, j + 1);
        mesh.triangles.push_back({a, b, c});
        mesh.triangles.push_back({a, c, d});
      }
  }
  return mesh;
}

PatchDeviation deviationOf(const PatchSurface& surface, const TriangleMesh& clay, int perSpan, int threads,
                           const WorkPart& part, double limitMm) {
  const TriangleMesh mesh = meshOf(surface, perSpan);
  PatchDeviation deviation;
  const std::vector<double> there = squaresFrom(mesh.positions, clay, threads);
  part.step(0.5);
  const std::vector<double> back = squaresFrom(clay.positions, mesh, threads);
  part.step(1);
  deviation.fromPatches = summed(there, mesh.positions);
  deviation.fromClay = summed(back, clay.positions);
  Far far;
  addFar(mesh.positions, there, limitMm, far);
  addFar(clay.positions, back, limitMm, far);
  Eigen::AlignedBox3d box;
  for (const Vec3d& each : clay.positions) box.extend(each);
  const double apart = box.sizes().maxCoeff() / 50;
  deviation.far = thinned(std::move(far), apart);
  Far folds;
  for (const uint32_t v : foldsOf(surface, mesh, perSpan)) folds.push_back({mesh.positions[v], 0});
  for (const PatchDeviation::Place& each : thinned(std::move(folds), apart)) deviation.foldsMm.push_back(each.mm);
  // A surface that turns evenly by t from place to place, l apart, strays from the triangles between them by l·t/4 at
  // most (what lies under a right-angled one on a ball), and so does the other.
  const PatchNormals normals(surface, mesh, perSpan);
  for (size_t t = 0; t < mesh.triangles.size(); ++t)
    for (size_t s = 0; s < 3; ++s) {
      const uint32_t from = mesh.triangles[t][s], to = mesh.triangles[t][(s + 1) % 3];
      const double bend = 0.5 * (mesh.positions[from] - mesh.positions[to]).norm() *
                          normals.clearAt(t, s).normalized().cross(normals.clearAt(t, (s + 1) % 3).normalized()).norm();
      deviation.boundMm = std::max(deviation.boundMm, std::sqrt(std::max(there[from], there[to])) + bend);
    }
  // Counts of the clay only the places that were looked at: its triangles are flat and it is not.
  deviation.boundMm = std::max(deviation.boundMm, deviation.mostMm());
  return deviation;
}

}  // namespace argil::clay
