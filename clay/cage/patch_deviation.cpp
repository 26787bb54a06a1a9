#include "clay/cage/patch_deviation.h"

#include <algorithm>
#include <cmath>

#include "clay/base/parallel.h"
#include "clay/mesh/nearest_triangle.h"

namespace argil::clay {

namespace {

constexpr int kBlock = 256;

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

}  // namespace argil::clay
