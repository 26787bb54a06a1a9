#include "clay/cage/fit_cage.h"

#include <algorithm>
#include <cmath>

#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "clay/base/error.h"
#include "clay/base/parallel.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/surface/surface.h"

namespace argil::clay {

namespace {

constexpr int kPerSide = 8;                            // places that are fitted along a side of a patch
constexpr double kStiff[] = {0.3, 0.05, 0.01, 0.003};  // how much the net is held straight, from round to round
constexpr int kRounds = 5;                             // of each
constexpr int kEvening = 3;                            // rounds that make the cage's edges even, before
constexpr int kPerSpan = 6;                            // places along a span that deviations are taken at
constexpr int kFootSpan = 2;  // places along a span that the clay's nearest is looked for among
constexpr int kBlock = 256;

using Sparse = Eigen::SparseMatrix<double>;
using Table = Eigen::Matrix<double, Eigen::Dynamic, 3>;

Vec3d nearestOn(const TriangleMesh& mesh, const NearestTriangle& tree, const Vec3d& p, uint32_t& hint) {
  const NearestTriangle::Hit hit = tree.nearest(p, hint);
  hint = hit.triangle;
  const auto& c = tree.corners(hit.triangle);
  return nearestOnTriangle(p, mesh.positions[c[0]], mesh.positions[c[1]], mesh.positions[c[2]]);
}

// Each vertex to the middle of those beside it and back onto the surface.
void makeEven(QuadMesh& cage, const TriangleMesh& clay, const NearestTriangle& tree) {
  std::vector<uint32_t> hints(cage.positions.size(), UINT32_MAX);
  for (int round = 0; round < kEvening; ++round) {
    std::vector<Vec3d> sum(cage.positions.size(), Vec3d::Zero());
    std::vector<int> count(cage.positions.size(), 0);
    for (const auto& quad : cage.quads)
      for (size_t s = 0; s < 4; ++s) {
        sum[quad[s]] += cage.positions[quad[(s + 1) & 3]] + cage.positions[quad[(s + 3) & 3]];
        count[quad[s]] += 2;
      }
    for (size_t v = 0; v < sum.size(); ++v) {
      const Vec3d middle = 0.5 * cage.positions[v] + 0.5 * sum[v] / count[v];
      cage.positions[v] = nearestOn(clay, tree, middle, hints[v]);
    }
  }
}

// The net's vertices in place, between the corners of their quads.
Table straightNet(const PatchNet& net, const QuadMesh& cage) {
  Table at(Eigen::Index(net.vertexCount()), 3);
  for (uint32_t f = 0; f < cage.quads.size(); ++f)
    for (int i = 0; i <= 4; ++i)
      for (int j = 0; j <= 4; ++j) {
        const double u = i / 4.0, v = j / 4.0;
        const auto& quad = cage.quads[f];
        at.row(net.vertex(f, i, j)) =
            ((1 - u) * (1 - v) * cage.positions[quad[0]] + u * (1 - v) * cage.positions[quad[1]] +
             u * v * cage.positions[quad[2]] + (1 - u) * v * cage.positions[quad[3]])
                .transpose();
      }
  return at;
}

// Rows of fitted places.
Sparse placesOf(const PatchNet& net, size_t quads) {
  std::vector<Eigen::Triplet<double>> entries;
  int row = 0;
  for (uint32_t f = 0; f < quads; ++f)
    for (int i = 0; i < kPerSide; ++i)
      for (int j = 0; j < kPerSide; ++j, ++row)
        for (const auto& [vertex, weight] :
             net.at(f, (i + 0.5) * kPatchSpans / kPerSide, (j + 0.5) * kPatchSpans / kPerSide))
          entries.emplace_back(row, int(vertex), weight);
  Sparse places(row, Eigen::Index(net.vertexCount()));
  places.setFromTriplets(entries.begin(), entries.end());
  return places;
}

// How far each vertex of the net lies from the mean of those beside it.
Sparse bendsOf(const PatchNet& net, size_t quads) {
  const auto count = Eigen::Index(net.vertexCount());
  std::vector<Eigen::Triplet<double>> entries;
  for (uint32_t f = 0; f < quads; ++f)
    for (int i = 0; i < 4; ++i)
      for (int j = 0; j < 4; ++j) {
        const std::array<uint32_t, 4> c{net.vertex(f, i, j), net.vertex(f, i + 1, j), net.vertex(f, i + 1, j + 1),
                                        net.vertex(f, i, j + 1)};
        for (size_t s = 0; s < 4; ++s) entries.emplace_back(int(c[s]), int(c[(s + 1) & 3]), 1.0);
      }
  Sparse beside(count, count);
  beside.setFromTriplets(entries.begin(), entries.end());  // each edge once either way, as every side has a partner
  Sparse bends(count, count);
  entries.clear();
  for (Eigen::Index column = 0; column < beside.outerSize(); ++column) {
    double degree = 0;
    for (Sparse::InnerIterator it(beside, column); it; ++it) degree += it.value();
    for (Sparse::InnerIterator it(beside, column); it; ++it)
      entries.emplace_back(int(column), int(it.row()), -it.value() / degree);
    entries.emplace_back(int(column), int(column), 1.0);
  }
  bends.setFromTriplets(entries.begin(), entries.end());
  return bends;
}

PatchSurface surfaceOf(const PatchNet& net, const QuadMesh& cage, const Table& at) {
  PatchSurface surface;
  surface.cage = cage;
  surface.patches = net.patches();
  surface.points.reserve(net.points().size());
  for (const Weights& weights : net.points()) {
    Vec3d sum = Vec3d::Zero();
    for (const auto& [vertex, weight] : weights) sum += weight * at.row(vertex).transpose();
    surface.points.push_back(sum);
  }
  for (uint32_t f = 0; f < cage.quads.size(); ++f)
    for (size_t s = 0; s < 4; ++s) surface.cage.positions[cage.quads[f][s]] = surface.points[cage.quads[f][s]];
  return surface;
}

OneWay summed(std::vector<double>& squared, const std::vector<Vec3d>& places) {
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

OneWay distances(const std::vector<Vec3d>& from, const TriangleMesh& to, int threads) {
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
  return summed(squared, from);
}

}  // namespace

TriangleMesh meshOf(const PatchSurface& surface, int perSpan) {
  TriangleMesh mesh;
  const int side = kPatchSpans * perSpan;
  const double step = 1.0 / perSpan;
  // Places of sides are those of both quads, to the last bits: welded by what they are numbered by.
  const QuadTopology topology(surface.cage.positions.size(), surface.cage.quads);
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
                           const WorkPart& part) {
  const TriangleMesh mesh = meshOf(surface, perSpan);
  PatchDeviation deviation;
  deviation.fromPatches = distances(mesh.positions, clay, threads);
  part.step(0.5);
  deviation.fromClay = distances(clay.positions, mesh, threads);
  part.step(1);
  // Between places a surface that turns by no more than its neighbouring triangles do strays from them by this much.
  double bend = 0;
  std::vector<Vec3d> normals(mesh.positions.size(), Vec3d::Zero());
  for (const auto& t : mesh.triangles)
    for (const uint32_t v : t)
      normals[v] += (mesh.positions[t[1]] - mesh.positions[t[0]]).cross(mesh.positions[t[2]] - mesh.positions[t[0]]);
  for (const auto& t : mesh.triangles)
    for (size_t s = 0; s < 3; ++s) {
      const Vec3d a = normals[t[s]].normalized(), b = normals[t[(s + 1) % 3]].normalized();
      bend = std::max(bend, (mesh.positions[t[s]] - mesh.positions[t[(s + 1) % 3]]).norm() * a.cross(b).norm());
    }
  deviation.boundMm = deviation.fromPatches.max + bend;
  return deviation;
}

namespace {

// Rows of the places of the patches that are nearest to `points`, by a mesh of the patches as they are.
Sparse placesNearest(const PatchNet& net, const PatchSurface& surface, const std::vector<Vec3d>& points, int threads) {
  const TriangleMesh mesh = meshOf(surface, kFootSpan);
  const NearestTriangle tree(mesh);
  // Triangles of a patch lie together, two a cell of its grid.
  constexpr int kCells = kPatchSpans * kFootSpan;
  std::vector<Weights> rows(points.size());
  parallelBlocks(
      points.size(), threads,
      [&](size_t begin, size_t end) {
        uint32_t hint = UINT32_MAX;
        for (size_t i = begin; i < end; ++i) {
          const NearestTriangle::Hit hit = tree.nearest(points[i], hint);
          hint = hit.triangle;
          const uint32_t index = tree.indexOf(hit.triangle);
          const auto& t = mesh.triangles[index];
          const Vec3d &a = mesh.positions[t[0]], ab = mesh.positions[t[1]] - a, ac = mesh.positions[t[2]] - a;
          const Vec3d foot = nearestOnTriangle(points[i], a, mesh.positions[t[1]], mesh.positions[t[2]]) - a;
          // foot = s ab + r ac
          const double bb = ab.dot(ab), bc = ab.dot(ac), cc = ac.dot(ac), det = bb * cc - bc * bc;
          const double fb = foot.dot(ab), fc = foot.dot(ac);
          const double s = det > 0 ? std::clamp((cc * fb - bc * fc) / det, 0.0, 1.0) : 0,
                       r = det > 0 ? std::clamp((bb * fc - bc * fb) / det, 0.0, 1.0) : 0;
          const uint32_t cell = index / 2 % (kCells * kCells);
          // The first triangle has the corners (0, 0), (1, 0), (1, 1) of its cell, the second (0, 0), (1, 1), (0, 1).
          const double u = cell / kCells + (index % 2 == 0 ? s + r : s),
                       v = cell % kCells + (index % 2 == 0 ? r : s + r);
          rows[i] = net.at(index / (2 * kCells * kCells), std::min(u, double(kCells)) / kFootSpan,
                           std::min(v, double(kCells)) / kFootSpan);
        }
      },
      kBlock);
  std::vector<Eigen::Triplet<double>> entries;
  for (size_t i = 0; i < rows.size(); ++i)
    for (const auto& [vertex, weight] : rows[i]) entries.emplace_back(int(i), int(vertex), weight);
  Sparse places(Eigen::Index(points.size()), Eigen::Index(net.vertexCount()));
  places.setFromTriplets(entries.begin(), entries.end());
  return places;
}

}  // namespace

FittedPatches fitPatches(const Version& version, size_t most, int threads, const WorkPart& part) {
  FittedPatches result;
  result.cage = coarseCage(version, most, part.part(0, 0.1));
  Surface surface(false, Grade::fine);
  surface.update(version, threads);
  const TriangleMesh clay = surface.toMesh();
  const NearestTriangle tree(clay);
  QuadMesh& cage = result.cage.mesh;
  makeEven(cage, clay, tree);
  part.step(0.2);

  const QuadTopology topology(cage.positions.size(), cage.quads);
  result.irregular = topology.irregular();
  const PatchNet net(topology);
  const Sparse places = placesOf(net, cage.quads.size());
  const Sparse bends = bendsOf(net, cage.quads.size());
  const Sparse fitted = places.transpose() * places, held = bends.transpose() * bends;
  Table at = straightNet(net, cage);
  // As many places of the clay as of the patches: what they miss pulls them.
  std::vector<Vec3d> points;
  const double stride = std::max(1.0, double(clay.positions.size()) / double(places.rows()));
  for (double i = 0; i < double(clay.positions.size()); i += stride) points.push_back(clay.positions[size_t(i)]);
  Table wanted(Eigen::Index(points.size()), 3);
  for (size_t i = 0; i < points.size(); ++i) wanted.row(Eigen::Index(i)) = points[i].transpose();

  std::vector<uint32_t> hints(size_t(places.rows()), UINT32_MAX);
  Eigen::SimplicialLDLT<Sparse> solver;
  const double share = double(places.rows() + Eigen::Index(points.size())) / double(net.vertexCount());
  const int all = int(std::size(kStiff)) * kRounds;
  int done = 0;
  for (const double stiff : kStiff) {
    for (int round = 0; round < kRounds; ++round) {
      const Table from = places * at;
      Table feet(from.rows(), 3);
      parallelBlocks(
          size_t(from.rows()), threads,
          [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i)
              feet.row(Eigen::Index(i)) =
                  nearestOn(clay, tree, from.row(Eigen::Index(i)).transpose(), hints[i]).transpose();
          },
          kBlock);
      const Sparse back = placesNearest(net, surfaceOf(net, cage, at), points, threads);
      const Sparse whole = fitted + Sparse(back.transpose() * back) + stiff * share * held;
      solver.compute(whole);
      if (solver.info() != Eigen::Success) throw Error("the cage cannot be fitted: its quads lie over each other");
      at = solver.solve(Table(places.transpose() * feet + back.transpose() * wanted));
      part.step(0.2 + 0.6 * ++done / all);
    }
  }
  result.surface = surfaceOf(net, cage, at);
  result.deviation = deviationOf(result.surface, clay, kPerSpan, threads, part.part(0.8, 1));
  return result;
}

}  // namespace argil::clay
