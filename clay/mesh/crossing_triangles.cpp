// The test of two triangles: Möller, A Fast Triangle-Triangle Intersection Test, Journal of Graphics Tools 2 (1997).

#include "clay/mesh/crossing_triangles.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <numeric>
#include <span>
#include <utility>
#include <vector>

#include "clay/base/error.h"

namespace argil::clay {

namespace {

using Corners = std::array<Vec3d, 3>;

/// The share of the largest coordinate by which two roundings to 32 bits move a corner at most.
constexpr double kRounding = 2.5e-7;
constexpr size_t kLeaf = 4;          // triangles of a leaf
constexpr double kParallel = 1e-10;  // sine of two planes' angle below which they have no line in common

struct Box {
  Vec3d low = Vec3d::Constant(INFINITY), high = Vec3d::Constant(-INFINITY);
  void add(const Vec3d& p) { low = low.cwiseMin(p), high = high.cwiseMax(p); }
  void add(const Box& box) { low = low.cwiseMin(box.low), high = high.cwiseMax(box.high); }
  [[nodiscard]] bool meets(const Box& box) const {
    return (low.array() <= box.high.array()).all() && (box.low.array() <= high.array()).all();
  }
};

/// Distances of a triangle's corners from a plane; those within the tolerance are 0.
struct Heights {
  std::array<double, 3> of{};
  [[nodiscard]] bool straddle() const {
    return std::max({of[0], of[1], of[2]}) > 0 && std::min({of[0], of[1], of[2]}) < 0;
  }
};

/// A triangle and its plane; the normal of one without area is zero.
struct Face {
  Corners corners;
  Vec3d normal;
  double offset = 0;
};
Face faceOf(const Corners& corners) {
  const Vec3d own = (corners[1] - corners[0]).cross(corners[2] - corners[0]);
  const double area = own.norm();
  const Vec3d normal = area > 0 ? Vec3d(own / area) : Vec3d(Vec3d::Zero());
  return {corners, normal, normal.dot(corners[0])};
}

Heights heightsOver(const Corners& triangle, const Face& face, double tolerance) {
  Heights heights;
  for (size_t k = 0; k < 3; ++k) {
    const double height = face.normal.dot(triangle[k]) - face.offset;
    heights.of[k] = std::abs(height) <= tolerance ? 0 : height;
  }
  return heights;
}

/// The part of the line along `direction` that a straddling triangle covers.
std::pair<double, double> spanOf(const Corners& triangle, const Heights& heights, const Vec3d& direction) {
  double low = INFINITY, high = -INFINITY;
  const auto add = [&](double at) { low = std::min(low, at), high = std::max(high, at); };
  for (size_t k = 0; k < 3; ++k) {
    const size_t next = (k + 1) % 3;
    const double from = heights.of[k], to = heights.of[next];
    if (from == 0) add(direction.dot(triangle[k]));
    if (from * to < 0) add(direction.dot(triangle[k] + from / (from - to) * (triangle[next] - triangle[k])));
  }
  return {low, high};
}

bool cross(const Face& faceA, const Face& faceB, double tolerance) {
  const Corners &a = faceA.corners, &b = faceB.corners;
  const Heights ofA = heightsOver(a, faceB, tolerance);
  if (!ofA.straddle()) return false;
  const Heights ofB = heightsOver(b, faceA, tolerance);
  if (!ofB.straddle()) return false;
  const Vec3d along = faceA.normal.cross(faceB.normal);
  const double sine = along.norm();
  if (sine < kParallel) return false;
  const auto [lowA, highA] = spanOf(a, ofA, along / sine);
  const auto [lowB, highB] = spanOf(b, ofB, along / sine);
  return std::min(highA, highB) - std::max(lowA, lowB) > tolerance;
}

/// A binary tree of boxes over triangles, halved at the median along the longest side.
class Tree {
 public:
  explicit Tree(const TriangleMesh& mesh) : order_(mesh.triangles.size()), boxes_(order_.size()) {
    std::iota(order_.begin(), order_.end(), 0u);
    for (size_t t = 0; t < boxes_.size(); ++t)
      for (const uint32_t corner : mesh.triangles[t]) boxes_[t].add(mesh.positions[corner]);
    nodes_.reserve(order_.size());
    build(0, uint32_t(order_.size()));
    // Neighbours in the tree lie beside each other in memory too.
    std::vector<Box> inOrder;
    inOrder.reserve(order_.size());
    faces_.reserve(order_.size());
    for (const uint32_t t : order_) {
      const auto& [a, b, c] = mesh.triangles[t];
      inOrder.push_back(boxes_[t]);
      faces_.push_back(faceOf({mesh.positions[a], mesh.positions[b], mesh.positions[c]}));
    }
    boxes_ = std::move(inOrder);
  }

  struct Node {
    Box box;
    uint32_t first = 0, count = 0;  // of boxes_ and faces_
    uint32_t next = 0;              // the node after this one and all below it
    bool leaf = false;
  };
  [[nodiscard]] std::span<const Node> nodes() const { return nodes_; }

  /// Counts the pairs of a leaf's triangles with each other and with those of the nodes behind it.
  [[nodiscard]] uint64_t pairsOf(uint32_t leaf, double tolerance) const {
    const Node& own = nodes_[leaf];
    uint64_t pairs = 0;
    for (uint32_t i = own.first; i < own.first + own.count; ++i)
      for (uint32_t k = i + 1; k < own.first + own.count; ++k) pairs += crosses(i, k, tolerance);
    for (uint32_t n = own.next; n < nodes_.size();) {
      const Node& node = nodes_[n];
      const bool meets = own.box.meets(node.box);
      if (meets && node.leaf) {
        for (uint32_t i = own.first; i < own.first + own.count; ++i) {
          if (!boxes_[i].meets(node.box)) continue;
          for (uint32_t k = node.first; k < node.first + node.count; ++k) pairs += crosses(i, k, tolerance);
        }
      }
      n = meets && !node.leaf ? n + 1 : node.next;
    }
    return pairs;
  }

 private:
  [[nodiscard]] bool crosses(uint32_t a, uint32_t b, double tolerance) const {
    return boxes_[a].meets(boxes_[b]) && cross(faces_[a], faces_[b], tolerance);
  }

  void build(uint32_t first, uint32_t count) {
    const auto at = nodes_.size();
    nodes_.emplace_back();
    Box box, middles;
    for (uint32_t i = first; i < first + count; ++i) {
      box.add(boxes_[order_[i]]);
      middles.add(Vec3d(boxes_[order_[i]].low + boxes_[order_[i]].high));
    }
    const bool leaf = count <= kLeaf;
    if (!leaf) {
      Eigen::Index axis = 0;
      (middles.high - middles.low).maxCoeff(&axis);
      const uint32_t half = count / 2;
      const auto key = [&](uint32_t t) { return boxes_[t].low[axis] + boxes_[t].high[axis]; };
      std::nth_element(order_.begin() + first, order_.begin() + first + half, order_.begin() + first + count,
                       [&](uint32_t a, uint32_t b) { return key(a) != key(b) ? key(a) < key(b) : a < b; });
      build(first, half);
      build(first + half, count - half);
    }
    nodes_[at] = {box, first, count, uint32_t(nodes_.size()), leaf};
  }

  std::vector<uint32_t> order_;
  std::vector<Box> boxes_;  // by triangles; in order_ once the tree is built
  std::vector<Face> faces_;
  std::vector<Node> nodes_;
};

}  // namespace

uint64_t countCrossings(const TriangleMesh& mesh, Job* job) {
  if (mesh.triangles.size() < 2) return 0;
  double largest = 0;
  for (const auto& triangle : mesh.triangles)
    for (const uint32_t corner : triangle) largest = std::max(largest, mesh.positions[corner].cwiseAbs().maxCoeff());
  const double tolerance = kRounding * largest;
  const Tree tree(mesh);
  std::vector<uint32_t> leaves;
  for (uint32_t n = 0; n < tree.nodes().size(); ++n)
    if (tree.nodes()[n].leaf) leaves.push_back(n);
  std::atomic<uint64_t> pairs = 0;
  const auto cancelled = [job] { return job != nullptr && job->cancelled(); };
  tbb::parallel_for(size_t{0}, leaves.size(), [&](size_t i) {
    if (cancelled() || pairs.load(std::memory_order_relaxed) >= kMostCrossings) return;
    if (const uint64_t own = tree.pairsOf(leaves[i], tolerance); own > 0)
      pairs.fetch_add(own, std::memory_order_relaxed);
  });
  if (cancelled()) throw Cancelled();
  return std::min(pairs.load(), kMostCrossings);
}

}  // namespace argil::clay
