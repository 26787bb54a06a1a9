#include "clay/mesh/wall_thickness.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <numeric>
#include <optional>
#include <string>

#include "clay/base/even_points.h"
#include "clay/base/parallel.h"
#include "clay/field/region_work.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/mesh/winding_number.h"

namespace argil::clay {

namespace {

constexpr double kLeast = 1e-4;     // of the longest side: the radius of the first ball
constexpr double kOpposite = -0.5;  // cosine of the angle between two faces that are the sides of a wall: over 120°
// Of a ball: what touches it less deep is no smaller one. Walls are told to two digits; and a ball in a ball-like body,
// whose surface lies everywhere within the chords of its triangles, would be looked for among all of them.
constexpr double kSmaller = 0.99;
constexpr int kMostShrinks = 32;
constexpr double kBeside = 0.02;  // of the wall: how far from it a point is asked whether it is inside
constexpr double kKept = 1e-3;    // of the surface: may be thinner than the voxel that keeps the walls
constexpr double kWalls =
    2;  // voxels across a wall that is surely kept: with fewer, flat ones shrink by a tenth and balls go
constexpr double kBody = 6;     // voxels across a body, by its volume: with fewer, corners round off too much of it
constexpr double kRough = 1.2;  // accuracy of winding numbers: inside or outside is all that is asked
constexpr size_t kPointsABlock = 64;

/// Whether the mesh is more than one piece of surface, which may overlap.
bool severalBodies(const TriangleMesh& mesh) {
  std::vector<uint32_t> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto find = [&](uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& [a, b, c] : mesh.triangles) {
    for (const uint32_t other : {b, c}) {
      const uint32_t x = find(a), y = find(other);
      parent[std::max(x, y)] = std::min(x, y);
    }
  }
  if (mesh.triangles.empty()) return false;
  const uint32_t first = find(mesh.triangles[0][0]);
  return std::any_of(mesh.triangles.begin(), mesh.triangles.end(), [&](const auto& t) { return find(t[0]) != first; });
}

/// Volume of the smallest set of triangles that hangs together and has one; infinity where none has.
double leastBody(const TriangleMesh& mesh) {
  std::vector<uint32_t> parent(mesh.positions.size());
  std::iota(parent.begin(), parent.end(), 0u);
  const auto find = [&](uint32_t i) {
    while (parent[i] != i) i = parent[i] = parent[parent[i]];
    return i;
  };
  for (const auto& [a, b, c] : mesh.triangles)
    for (const uint32_t other : {b, c}) {
      const uint32_t x = find(a), y = find(other);
      parent[std::max(x, y)] = std::min(x, y);
    }
  std::vector<double> volume(mesh.positions.size(), 0);
  for (const auto& [a, b, c] : mesh.triangles) {
    const uint32_t root = find(a);
    const Vec3d& from = mesh.positions[root];
    volume[root] += (mesh.positions[a] - from).dot((mesh.positions[b] - from).cross(mesh.positions[c] - from)) / 6;
  }
  double least = INFINITY, most = 0;
  for (const double each : volume) most = std::max(most, std::abs(each));
  for (const double each : volume)
    if (std::abs(each) > 1e-9 * most) least = std::min(least, std::abs(each));
  return least;
}

class Walls {
 public:
  Walls(const TriangleMesh& mesh, double longest, bool insideOut)
      : mesh_(mesh), nearest_(mesh), longest_(longest), sign_(insideOut ? -1 : 1) {
    if (severalBodies(mesh)) winding_.emplace(mesh, kRough);
  }

  /// Twice the radius of the largest ball that touches the surface in `p` from within and has another touching point
  /// opposite; infinity where there is none. The balls grow until one meets the other side, so that what is near and
  /// not opposite (the next face at an edge, roughness) is passed over; then they shrink to where they only touch
  /// (Ma, Bae, Choi 2012).
  [[nodiscard]] double at(const Vec3d& p, const Vec3d& outwards) const {
    const Vec3d n = sign_ * outwards;
    uint32_t hint = UINT32_MAX;
    // The ball in p that touches the point nearest to the middle of the one given; its own size when that is empty.
    Vec3d touched = p, normal = n;
    const auto touching = [&](double radius) {
      const Vec3d middle = p - radius * n;
      const NearestTriangle::Hit hit = nearest_.nearerThan(middle, radius * kSmaller, hint);
      if (hit.triangle == UINT32_MAX) return radius;
      hint = hit.triangle;
      const auto& [a, b, c] = nearest_.corners(hint);
      const Vec3d &x = mesh_.positions[a], &y = mesh_.positions[b], &z = mesh_.positions[c];
      touched = nearestOnTriangle(middle, x, y, z);
      normal = sign_ * (y - x).cross(z - x).normalized();
      const double depth = n.dot(p - touched);
      if (!(depth > 0)) return radius;
      const double smaller = (p - touched).squaredNorm() / (2 * depth);
      return smaller < radius * kSmaller ? smaller : radius;
    };
    const auto opposite = [&] { return n.dot(normal) < kOpposite; };
    for (double radius = kLeast * longest_; radius < longest_; radius *= 2) {
      double found = touching(radius);
      if (!(found < radius) || !opposite()) continue;
      Vec3d end = touched;
      for (int i = 0; i < kMostShrinks; ++i) {
        const double smaller = touching(found);
        if (!(smaller < found) || !opposite()) break;
        found = smaller;
        end = touched;
      }
      return bounds(p, end) ? 2 * found : INFINITY;
    }
    return INFINITY;
  }

 private:
  /// Beyond both ends is air: else they are faces within other bodies.
  [[nodiscard]] bool bounds(const Vec3d& p, const Vec3d& end) const {
    if (!winding_) return true;
    const Vec3d out = kBeside * (p - end);
    return std::abs(winding_->at(p + out)) < 0.5 && std::abs(winding_->at(end - out)) < 0.5;
  }

  const TriangleMesh& mesh_;
  NearestTriangle nearest_;
  std::optional<WindingNumber> winding_;
  double longest_, sign_;
};

}  // namespace

double WallThickness::shareThinner(double mm) const {
  if (points == 0) return 0;
  const auto end = std::lower_bound(wallsMm.begin(), wallsMm.end(), mm);
  return double(end - wallsMm.begin()) / double(points);
}

double WallThickness::keepingVoxelMm() const {
  const auto allowed = size_t(kKept * double(points));
  if (allowed >= wallsMm.size()) return 0;
  const double most = std::min(wallsMm[allowed] / kWalls, std::cbrt(leastBodyMm3) / kBody);
  const double digit = std::pow(10, std::floor(std::log10(most)) - 1);
  const std::string text = fmt::format("{:.2g}", std::floor(most / digit + 1e-3) * digit);
  double rounded = 0;
  std::from_chars(text.data(), text.data() + text.size(), rounded);
  return rounded;
}

double medianThickness(const TriangleMesh& mesh, std::span<const SurfacePlace> places) {
  if (places.empty() || mesh.triangles.empty()) return 0;
  Vec3d low = Vec3d::Constant(INFINITY), high = -low;
  for (const auto& t : mesh.triangles)
    for (const uint32_t v : t) low = low.cwiseMin(mesh.positions[v]), high = high.cwiseMax(mesh.positions[v]);
  const Walls walls(mesh, (high - low).maxCoeff(), false);
  std::vector<std::pair<double, double>> found;  // thickness, area
  double all = 0;
  for (const SurfacePlace& place : places)
    if (const double thick = walls.at(place.at, place.outwards.normalized()); std::isfinite(thick)) {
      found.emplace_back(thick, place.area);
      all += place.area;
    }
  std::sort(found.begin(), found.end());
  double sum = 0;
  for (const auto& [thick, area] : found)
    if ((sum += area) >= all / 2) return thick;
  return 0;
}

WallThickness wallThickness(const TriangleMesh& mesh, const WorkPart& part, size_t points, int threads) {
  WallThickness result;
  part.step(0);
  result.leastBodyMm3 = leastBody(mesh);
  std::vector<double> area;  // of all triangles so far
  area.reserve(mesh.triangles.size());
  Vec3d low = Vec3d::Constant(INFINITY), high = -low;
  double sum = 0, volume = 0;
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3d &a = mesh.positions[i], &b = mesh.positions[j], &c = mesh.positions[k];
    low = low.cwiseMin(a).cwiseMin(b).cwiseMin(c);
    high = high.cwiseMax(a).cwiseMax(b).cwiseMax(c);
    const Vec3d middle = mesh.positions[mesh.triangles[0][0]];
    volume += (a - middle).dot((b - middle).cross(c - middle));
    area.push_back(sum += (b - a).cross(c - a).norm() / 2);
  }
  if (!(sum > 0) || !std::isfinite(sum)) return result;
  part.step(0.05);
  const Walls walls(mesh, (high - low).maxCoeff(), volume < 0);
  part.step(0.4);

  result.points = points;
  std::vector<double> found(points);
  constexpr size_t kSlice = 2048;  // between two looks at the job
  for (size_t begin = 0; begin < points; begin += kSlice) {
    const size_t count = std::min(kSlice, points - begin);
    parallelBlocks(
        count, threadCount(threads),
        [&](size_t from, size_t to) {
          for (size_t s = begin + from; s < begin + to; ++s) {
            const double place = sum * (double(s) + 0.5) / double(points);
            const auto above = std::upper_bound(area.begin(), area.end(), place);
            const size_t t = std::min(size_t(above - area.begin()), area.size() - 1);
            const auto& [i, j, k] = mesh.triangles[t];
            const Vec3d &a = mesh.positions[i], &b = mesh.positions[j], &c = mesh.positions[k];
            found[s] = walls.at(evenPoint(a, b, c, int(s)), (b - a).cross(c - a).normalized());
          }
        },
        kPointsABlock);
    part.step(0.4 + 0.6 * double(begin + count) / double(points));
  }
  for (const double each : found)
    if (std::isfinite(each)) result.wallsMm.push_back(each);
  std::sort(result.wallsMm.begin(), result.wallsMm.end());
  return result;
}

}  // namespace argil::clay
