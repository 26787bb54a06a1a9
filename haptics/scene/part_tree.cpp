#include "haptics/scene/part_tree.h"

#include <Eigen/Eigenvalues>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace argil::haptics {
namespace {

constexpr size_t kLeaf = 4;
constexpr int kBins = 16;
// Past so many splits halves alone are made, so that depth is bounded: 2^28 triangles take 26 halvings.
constexpr int kHeuristicDepth = 40;
// Of more triangles a disc is read off their box: they are few, and to fit them well costs most of all.
constexpr size_t kDiscFrom = 2048;
constexpr size_t kReportEvery = 16384;  // Triangles.

struct Box {
  Vec3f lo = Vec3f::Constant(std::numeric_limits<float>::max());
  Vec3f hi = Vec3f::Constant(std::numeric_limits<float>::lowest());
  void add(const Vec3f& p) { lo = lo.cwiseMin(p), hi = hi.cwiseMax(p); }
  void add(const Box& other) { lo = lo.cwiseMin(other.lo), hi = hi.cwiseMax(other.hi); }
  [[nodiscard]] double area() const {
    const Vec3d s = (hi - lo).cast<double>().cwiseMax(0.0);
    return s.x() * s.y() + s.y() * s.z() + s.z() * s.x();
  }
};

struct Item {
  Box box;
  uint32_t triangle = 0;
  [[nodiscard]] float middle(int axis) const { return 0.5f * box.lo[axis] + 0.5f * box.hi[axis]; }
  [[nodiscard]] Vec3f middle() const { return 0.5f * box.lo + 0.5f * box.hi; }
};

struct Run {
  size_t begin = 0, end = 0;
  int depth = 0;
  [[nodiscard]] size_t size() const { return end - begin; }
};

class Builder {
 public:
  Builder(const std::vector<PartTriangle>& triangles, Job& job, double from)
      : triangles_(triangles), items_(triangles.size()), job_(job), from_(from) {
    for (size_t i = 0; i < items_.size(); ++i) {
      items_[i].triangle = static_cast<uint32_t>(i);
      for (const Vec3f& corner : triangles[i]) items_[i].box.add(corner);
    }
  }

  PartTree build() {
    makeNode({0, items_.size(), 0});
    tree_.order.reserve(items_.size());
    for (const Item& item : items_) tree_.order.push_back(item.triangle);
    return std::move(tree_);
  }

 private:
  size_t makeNode(const Run& whole) {
    const size_t index = tree_.nodes.size();
    tree_.nodes.emplace_back();
    std::array<Run, 4> runs{whole};
    size_t count = 1;
    while (count < 4) {
      // The one with most triangles: nodes fill up and depth stays low.
      const auto widest = std::max_element(runs.begin(), runs.begin() + static_cast<ptrdiff_t>(count),
                                           [](const Run& a, const Run& b) { return a.size() < b.size(); });
      if (widest->size() <= kLeaf) break;
      const size_t middle = split(*widest);
      runs[count++] = {middle, widest->end, widest->depth + 1};
      *widest = {widest->begin, middle, widest->depth + 1};
    }
    PartNode node;
    node.half.setZero();
    node.radius.setConstant(-1);
    for (int i = 0; i < 3; ++i) node.centre[size_t(i)].setZero(), node.axis[size_t(i)].setZero();
    node.child.fill(0);
    for (size_t i = 0; i < count; ++i) {
      const Run& run = runs[i];
      bound(run, node, static_cast<int>(i));
      if (run.size() <= kLeaf) {
        node.child[i] = ~static_cast<int32_t>(run.begin * kLeaf + run.size() - 1);
        report(run.size());
      } else {
        node.child[i] = static_cast<int32_t>(makeNode(run));
      }
    }
    tree_.nodes[index] = node;
    return index;
  }

  // Where the run is parted, both sides not empty; its items are put in order.
  size_t split(const Run& run) {
    Box middles;
    for (size_t i = run.begin; i < run.end; ++i) middles.add(items_[i].middle());
    const Vec3f size = middles.hi - middles.lo;
    int longest = 0;
    size.maxCoeff(&longest);
    const auto begin = items_.begin() + static_cast<ptrdiff_t>(run.begin),
               end = items_.begin() + static_cast<ptrdiff_t>(run.end);
    if (run.depth < kHeuristicDepth) {
      std::array<std::array<Box, kBins>, 3> boxes;
      std::array<std::array<size_t, kBins>, 3> counts{};
      const Vec3f perBin = (size.array() > 1e-30f).select(float(kBins) / size.array(), 0.0f);
      for (auto it = begin; it != end; ++it) {
        const Vec3f at = (it->middle() - middles.lo).cwiseProduct(perBin);
        for (size_t axis = 0; axis < 3; ++axis) {
          const size_t bin = binOf(at[static_cast<int>(axis)]);
          boxes[axis][bin].add(it->box);
          ++counts[axis][bin];
        }
      }
      int bestAxis = -1;
      size_t bestBin = 0;
      double best = std::numeric_limits<double>::max();
      for (size_t axis = 0; axis < 3; ++axis) {
        std::array<double, kBins> below{};
        Box box;
        size_t n = 0;
        for (size_t b = 0; b + 1 < kBins; ++b) {
          box.add(boxes[axis][b]);
          n += counts[axis][b];
          below[b] = n ? box.area() * double(n) : 0;
        }
        box = Box();
        n = 0;
        for (size_t b = kBins - 1; b > 0; --b) {
          box.add(boxes[axis][b]);
          n += counts[axis][b];
          if (n == 0 || n == run.size()) continue;
          const double cost = below[b - 1] + box.area() * double(n);
          if (cost < best) best = cost, bestAxis = static_cast<int>(axis), bestBin = b;
        }
      }
      if (bestAxis >= 0) {
        const float lo = middles.lo[bestAxis], scale = perBin[bestAxis];
        const auto middle = std::partition(
            begin, end, [=](const Item& item) { return binOf((item.middle(bestAxis) - lo) * scale) < bestBin; });
        if (middle != begin && middle != end) return static_cast<size_t>(middle - items_.begin());
      }
    }
    const auto middle = begin + (end - begin) / 2;
    std::nth_element(begin, middle, end, [=](const Item& a, const Item& b) {
      const float ma = a.middle(longest), mb = b.middle(longest);
      return ma < mb || (ma == mb && a.triangle < b.triangle);
    });
    return static_cast<size_t>(middle - items_.begin());
  }

  static size_t binOf(float at) { return static_cast<size_t>(std::clamp(static_cast<int>(at), 0, kBins - 1)); }

  // The disc of a run: its axis is the direction in which the corners spread least.
  void bound(const Run& run, PartNode& node, int lane) const {
    Box box;
    for (size_t i = run.begin; i < run.end; ++i) box.add(items_[i].box);
    const Vec3d middle = 0.5 * (box.lo.cast<double>() + box.hi.cast<double>());
    if (run.size() > kDiscFrom) {
      const Vec3d half = box.hi.cast<double>() - middle;
      store(node, lane, middle, Vec3f::UnitZ(), half.z(), half.head<2>().norm());
      return;
    }
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    Vec3d sum = Vec3d::Zero();
    for (size_t i = run.begin; i < run.end; ++i)
      for (const Vec3f& corner : triangles_[items_[i].triangle]) {
        const Vec3d v = corner.cast<double>() - middle;
        sum += v;
        spread += v * v.transpose();
      }
    spread -= sum * sum.transpose() / (3.0 * double(run.size()));
    Vec3d direction = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>().computeDirect(spread).eigenvectors().col(0);
    if (!direction.allFinite() || !(direction.norm() > 0.5)) direction = Vec3d::UnitZ();
    const Vec3f axis = direction.normalized().cast<float>();
    // Measured with the axis as it is stored.
    double low = std::numeric_limits<double>::max(), high = -low, radius2 = 0;
    for (size_t i = run.begin; i < run.end; ++i)
      for (const Vec3f& corner : triangles_[items_[i].triangle]) {
        const Vec3d v = corner.cast<double>() - middle;
        const double along = v.dot(axis.cast<double>());
        low = std::min(low, along);
        high = std::max(high, along);
        radius2 = std::max(radius2, (v - along * axis.cast<double>()).squaredNorm());
      }
    const Vec3d centre = middle + 0.5 * (low + high) * axis.cast<double>();
    store(node, lane, centre, axis, 0.5 * (high - low), std::sqrt(radius2));
  }

  static void store(PartNode& node, int lane, const Vec3d& centre, const Vec3f& axis, double half, double radius) {
    for (int k = 0; k < 3; ++k) {
      node.centre[size_t(k)][lane] = static_cast<float>(centre[k]);
      node.axis[size_t(k)][lane] = axis[k];
    }
    node.half[lane] = static_cast<float>(half);
    node.radius[lane] = static_cast<float>(radius);
  }

  void report(size_t triangles) {
    const size_t before = done_;
    done_ += triangles;
    if (before / kReportEvery != done_ / kReportEvery)
      job_.step(from_ + (1 - from_) * double(done_) / double(items_.size()));
  }

  const std::vector<PartTriangle>& triangles_;
  std::vector<Item> items_;
  PartTree tree_;
  Job& job_;
  double from_;
  size_t done_ = 0;
};

}  // namespace

PartTree buildPartTree(const std::vector<PartTriangle>& triangles, Job& job, double from) {
  return Builder(triangles, job, from).build();
}

}  // namespace argil::haptics
