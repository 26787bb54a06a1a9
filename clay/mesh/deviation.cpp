#include <algorithm>
#include <cmath>
#include <limits>
#include <mutex>
#include <thread>

#include "clay/base/parallel.h"
#include "clay/mesh/measure_deviation.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/mesh/reduce.h"

namespace argil::clay {

namespace {

/// Points a side: about 10 s of one core.
constexpr uint64_t kMostPoints = 8'000'000;
/// Points stand as close as this part of the diagonal, or the other mesh's mean edge where that is less.
constexpr double kSpacing = 1.0 / 128;
constexpr uint32_t kMostParts = 1024;  ///< Of an edge.
constexpr size_t kBlock = 4096;        ///< Triangles: sums are made by blocks, so that they do not depend on threads.

/// Longest edge of a triangle in parts of `spacing`, at least one.
uint32_t partsOf(const TriangleMesh& mesh, const std::array<uint32_t, 3>& t, double spacing) {
  const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
  const double longest = std::sqrt(std::max({(b - a).squaredNorm(), (c - b).squaredNorm(), (a - c).squaredNorm()}));
  return static_cast<uint32_t>(std::clamp(std::ceil(longest / spacing), 1.0, double(kMostParts)));
}

/// Calls visit(point) for the points that belong to a triangle: its first corner, the middles of the parts of those
/// edges that run upwards (their twins run downwards), and the middles of the small triangles that its parts make.
template <class Visit>
void forPoints(const TriangleMesh& mesh, const std::array<uint32_t, 3>& t, uint32_t parts, const Visit& visit) {
  const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
  const double n = parts;
  visit(a);
  for (size_t k = 0; k < 3; ++k) {
    if (t[k] > t[(k + 1) % 3]) continue;
    const Vec3d &from = mesh.positions[t[k]], &to = mesh.positions[t[(k + 1) % 3]];
    for (uint32_t i = 0; i < parts; ++i) visit(Vec3d(from + (to - from) * ((i + 0.5) / n)));
  }
  for (uint32_t i = 0; i < parts; ++i)
    for (uint32_t j = 0; i + j < parts; ++j) {
      visit(Vec3d(a + (b - a) * ((i + 1.0 / 3) / n) + (c - a) * ((j + 1.0 / 3) / n)));
      if (i + j + 1 < parts) visit(Vec3d(a + (b - a) * ((i + 2.0 / 3) / n) + (c - a) * ((j + 2.0 / 3) / n)));
    }
}

/// As many as forPoints visits, on average.
uint64_t pointsFor(uint32_t parts) {
  return 1 + (3 * uint64_t(parts) + 1) / 2 + uint64_t(parts) * parts;
}

uint64_t countPoints(const TriangleMesh& mesh, double spacing) {
  uint64_t count = 0;
  for (const auto& t : mesh.triangles) count += pointsFor(partsOf(mesh, t, spacing));
  return count;
}

double meanEdge(const TriangleMesh& mesh) {
  double sum = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    sum += (mesh.positions[b] - mesh.positions[a]).norm() + (mesh.positions[c] - mesh.positions[b]).norm();
  return sum / (2 * double(mesh.triangles.size()));
}

struct OneWay {
  double most = 0, squares = 0, spacing = 0;
  uint64_t points = 0, passedOver = 0;
  std::vector<uint32_t> beyond;
};

/// `beyond` gets the vertices of the original next to points that lie farther than `limit`: of the triangle that they
/// are on, or else of the one that is nearest.
OneWay oneWay(const TriangleMesh& from, const TriangleMesh& to, double diagonal, double limit, bool fromOriginal,
              const WorkPart& work) {
  double spacing = std::max(std::min(kSpacing * diagonal, meanEdge(to)), diagonal * 1e-6);
  uint64_t count = countPoints(from, spacing);
  for (; count > kMostPoints && count > 4 * from.triangles.size(); count = countPoints(from, spacing)) spacing *= 1.5;
  // Fewer points on each triangle is not possible: fewer triangles.
  const size_t stride = (count + kMostPoints - 1) / kMostPoints;
  const size_t looked = (from.triangles.size() + stride - 1) / stride;
  OneWay result;
  result.passedOver = from.triangles.size() - looked;

  const NearestTriangle tree(to);
  std::vector<OneWay> blocks((looked + kBlock - 1) / kBlock);
  std::atomic<size_t> done{0};
  parallelBlocks(
      blocks.size(), static_cast<int>(std::max(1u, std::thread::hardware_concurrency())),
      [&](size_t begin, size_t end) {
        for (size_t b = begin; b < end; ++b) {
          OneWay& sum = blocks[b];
          uint32_t hint = UINT32_MAX;
          for (size_t i = b * kBlock; i < std::min((b + 1) * kBlock, looked); ++i) {
            const auto& t = from.triangles[i * stride];
            const uint32_t parts = partsOf(from, t, spacing);
            forPoints(from, t, parts, [&](const Vec3d& p) {
              const NearestTriangle::Hit hit = tree.nearest(p, hint);
              hint = hit.triangle;
              sum.most = std::max(sum.most, hit.squared);
              sum.squares += hit.squared;
              ++sum.points;
              if (hit.squared > limit * limit) {
                const auto& corners = fromOriginal ? t : tree.corners(hit.triangle);
                sum.beyond.insert(sum.beyond.end(), corners.begin(), corners.end());
              }
            });
            const Vec3d &a = from.positions[t[0]], &b2 = from.positions[t[1]], &c = from.positions[t[2]];
            const double longest =
                std::sqrt(std::max({(b2 - a).squaredNorm(), (c - b2).squaredNorm(), (a - c).squaredNorm()}));
            sum.spacing = std::max(sum.spacing, longest / parts);
          }
          work.step(double(++done) / double(blocks.size()));
        }
      },
      1);
  for (const OneWay& sum : blocks) {
    result.most = std::max(result.most, sum.most);
    result.squares += sum.squares;
    result.points += sum.points;
    result.beyond.insert(result.beyond.end(), sum.beyond.begin(), sum.beyond.end());
    result.spacing = std::max(result.spacing, sum.spacing);
  }
  return result;
}

}  // namespace

Deviation measureDeviation(const TriangleMesh& original, const TriangleMesh& other, double limitMm,
                           std::vector<uint32_t>& beyond, const WorkPart& work) {
  if (original.triangles.empty() || other.triangles.empty())
    throw Error("there is no deviation from a mesh without triangles: add a surface");
  Eigen::AlignedBox3d box;
  for (const TriangleMesh* mesh : {&original, &other})
    for (const auto& t : mesh->triangles)
      for (const uint32_t v : t) box.extend(mesh->positions[v]);
  const double diagonal = std::max(box.diagonal().norm(), 1e-12);
  const OneWay there = oneWay(original, other, diagonal, limitMm, true, work.part(0, 0.5));
  const OneWay back = oneWay(other, original, diagonal, limitMm, false, work.part(0.5, 1));
  for (const OneWay* way : {&there, &back}) beyond.insert(beyond.end(), way->beyond.begin(), way->beyond.end());
  Deviation result;
  result.toReducedMm = std::sqrt(there.most);
  result.fromReducedMm = std::sqrt(back.most);
  result.points = there.points + back.points;
  result.rmsMm = std::sqrt((there.squares + back.squares) / double(result.points));
  result.spacingMm = std::max(there.spacing, back.spacing);
  result.passedOver = there.passedOver + back.passedOver;
  return result;
}

Deviation deviation(const TriangleMesh& original, const TriangleMesh& other, Job* job) {
  std::vector<uint32_t> none;
  return measureDeviation(original, other, std::numeric_limits<double>::infinity(), none, WorkPart(job));
}

}  // namespace argil::clay
