#include "clay/mesh/corners_apart.h"

#include <algorithm>
#include <utility>
#include <vector>

namespace argil::clay {

namespace {

/// Corners that are nearer, relative to the largest coordinate, may become one: two to four last digits.
constexpr double kNear = 0x1p-22;
/// Vertices are not moved where that is more than this part of the mesh's size.
constexpr double kMostOfSize = 1e-2;
/// Passes at most; a moved vertex hardly ever meets another.
constexpr int kMostPasses = 8;
/// Vertices in one place go into so many directions, and as many times farther.
constexpr uint32_t kDirections = 6, kDistances = 4;

Vec3d offset(uint32_t number) {
  const uint32_t direction = number % kDirections, distance = number / kDirections % kDistances + 1;
  Vec3d by = Vec3d::Zero();
  by[direction / 2] = (direction % 2 == 0 ? 2.0 : -2.0) * distance;
  return by;
}

double largestOf(std::span<const Vec3d> positions) {
  double largest = 0;
  for (const Vec3d& p : positions) largest = std::max(largest, p.cwiseAbs().maxCoeff());
  return largest;
}

class Mover {
 public:
  explicit Mover(double largest) : near_(kNear * largest) {}

  /// Moves corners of the triangles among `positions`, of which the first is the vertex of that number.
  void move(uint32_t first, std::span<Vec3d> positions, std::span<const std::array<uint32_t, 3>> triangles) {
    for (const auto& triangle : triangles) {
      for (size_t k = 0; k < 3; ++k) {
        const uint32_t a = triangle[k], b = triangle[(k + 1) % 3];
        if (a == b) continue;
        const Vec3d& p = positions[a - first];
        if ((p - positions[b - first]).cwiseAbs().maxCoeff() > near_) continue;
        const uint32_t later = std::max(a, b);
        Vec3d& place = positions[later - first];
        place += near_ * offset(moves_++);
        moved[later] = place;
        any_ = true;
      }
    }
  }
  /// True when something was moved since it was asked before.
  [[nodiscard]] bool any() { return std::exchange(any_, false); }

  std::map<uint32_t, Vec3d> moved;

 private:
  double near_;
  uint32_t moves_ = 0;
  bool any_ = false;
};

}  // namespace

std::map<uint32_t, Vec3d> cornersApart(const MeshPieces& pieces) {
  double largest = 0;
  Vec3d low = Vec3d::Constant(1e300), high = Vec3d::Constant(-1e300);
  pieces([&](uint32_t, std::span<const Vec3d> positions, std::span<const std::array<uint32_t, 3>>) {
    largest = std::max(largest, largestOf(positions));
    for (const Vec3d& p : positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
  });
  const double size = (high - low).maxCoeff();
  // So far from zero that 32 bits do not hold the mesh anyway.
  if (kNear * largest > kMostOfSize * size) return {};
  Mover mover(largest);
  for (int pass = 0; pass == 0 || (mover.any() && pass < kMostPasses); ++pass) {
    std::vector<Vec3d> window;
    uint32_t windowFirst = 0, last = 0;
    pieces([&](uint32_t first, std::span<const Vec3d> positions, std::span<const std::array<uint32_t, 3>> triangles) {
      window.erase(window.begin(), window.begin() + std::ptrdiff_t(last - windowFirst));
      windowFirst = last, last = first;
      window.insert(window.end(), positions.begin(), positions.end());
      for (auto at = mover.moved.lower_bound(first); at != mover.moved.end() && at->first - windowFirst < window.size();
           ++at)
        window[at->first - windowFirst] = at->second;
      mover.move(windowFirst, window, triangles);
    });
  }
  return std::move(mover.moved);
}

std::vector<bool> haveOnePlaceTwice(const TriangleMesh& mesh) {
  const double near = kNear * largestOf(mesh.positions);
  std::vector<bool> marks(mesh.triangles.size());
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = mesh.triangles[t];
    const auto together = [&](uint32_t i, uint32_t j) {
      return (mesh.positions[i] - mesh.positions[j]).cwiseAbs().maxCoeff() <= near;
    };
    marks[t] = together(a, b) || together(b, c) || together(c, a);
  }
  return marks;
}

size_t moveCornersApart(TriangleMesh& mesh) {
  Mover mover(largestOf(mesh.positions));
  for (int pass = 0; pass == 0 || (mover.any() && pass < kMostPasses); ++pass)
    mover.move(0, mesh.positions, mesh.triangles);
  return mover.moved.size();
}

}  // namespace argil::clay
