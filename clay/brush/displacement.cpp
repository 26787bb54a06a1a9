#include "clay/brush/displacement.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <utility>
#include <vector>

namespace argil::clay {

void DisplacementField::prepare(int margin) {
  if (margin <= margin_) return;
  margin_ = margin;
  const auto n = static_cast<size_t>(kBrickEdge + 2 * margin);
  window_ = std::make_unique_for_overwrite<Displacement[]>(n * n * n);
}

// Copies n³ nodes; false where no block holds any of them (then they are zero).
bool DisplacementField::gather(Coord firstNode, int n, Displacement* window) const {
  const Coord low = firstNode >> kBrickBits, high = (firstNode + Coord{n - 1, n - 1, n - 1}) >> kBrickBits;
  bool any = false;
  for (int bx = low.x; bx <= high.x; ++bx)
    for (int by = low.y; by <= high.y; ++by)
      for (int bz = low.z; bz <= high.z; ++bz) {
        const auto found = blocks_.find({bx, by, bz});
        const Block* block = found == blocks_.end() ? nullptr : found->second.get();
        any = any || block;
        const Coord first = Coord{bx, by, bz} * kBrickEdge - firstNode;
        const int x0 = std::max(first.x, 0), x1 = std::min(first.x + kBrickEdge, n), y0 = std::max(first.y, 0),
                  y1 = std::min(first.y + kBrickEdge, n);
        const int z0 = std::max(first.z, 0), z1 = std::min(first.z + kBrickEdge, n);
        const size_t bytes = static_cast<size_t>(z1 - z0) * sizeof(Displacement);
        for (int x = x0; x < x1; ++x)
          for (int y = y0; y < y1; ++y) {
            Displacement* row = window + (x * n + y) * n + z0;
            if (block)
              std::memcpy(row, &block->node[Brick::offset(x - first.x, y - first.y, z0 - first.z)], bytes);
            else
              std::memset(static_cast<void*>(row), 0, bytes);
          }
      }
  return any;
}

float DisplacementField::farthest(Coord block) const {
  const auto found = blocks_.find(block);
  if (found == blocks_.end()) return 0;
  Eigen::Array4f most = Eigen::Array4f::Zero();
  for (const Displacement& each : found->second->node) most = most.max(Eigen::Map<const Eigen::Array4f>(&each.x).abs());
  return most.head<3>().maxCoeff();
}

DisplacementField::Refinement DisplacementField::refinement(Coord brick) const {
  const Coord first = brick * kBrickEdge - Coord{1, 1, 1};
  Refinement r;
  if (spacing_ == 1) {
    r.first = first;
    r.n = 10;
    return r;
  }
  int from[3];
  for (int axis = 0; axis < 3; ++axis) {
    const int voxel = axis == 0 ? first.x : axis == 1 ? first.y : first.z;
    for (int i = 0; i < 10; ++i) {
      const double s = (voxel + i - 0.5 * (spacing_ - 1)) / spacing_;
      const double floored = std::floor(s);
      r.base[axis][i] = static_cast<int>(floored) - 1;
      cubicWeights(static_cast<float>(s - floored), r.weights[axis][i]);
    }
    from[axis] = r.base[axis][0];
    r.n = std::max(r.n, r.base[axis][9] - r.base[axis][0] + 4);
    for (int& each : r.base[axis]) each -= from[axis];
  }
  r.first = {from[0], from[1], from[2]};
  return r;
}

namespace {

constexpr int kMostNodes = 10 + 4;  // along an axis of a refinement's window

Displacement* scratchNodes() {
  thread_local auto nodes = std::make_unique<Displacement[]>(kMostNodes * kMostNodes * kMostNodes +
                                                             kMostNodes * kMostNodes * 10 + kMostNodes * 100);
  return nodes.get();
}

}  // namespace

namespace {

using Node = Eigen::Array4f;

// From this spacing on the nodes around a brick reach far beyond it, and bounds of the nodes would be far from those of
// its voxels.
constexpr int kTightFrom = 8;

// Nodes along an axis, and between which of them some voxels lie, counted from the first.
struct Along {
  int from = 0, count = 0;
  double low = 0, high = 0;  // of the voxels
  [[nodiscard]] int places() const { return static_cast<int>(std::ceil(high)) - static_cast<int>(std::floor(low)) + 1; }
  // Where something that is straight between nodes is largest or least: at both ends and at the nodes between them.
  [[nodiscard]] double place(int i) const { return std::clamp(std::floor(low) + i, low, high); }
};

// Nodes as `outer` times a line of `count` times `inner` that follow each other.
struct Lines {
  size_t outer, count, inner;
};

// The largest second difference along the lines, of each coordinate.
Node mostBend(const Node* nodes, const Lines& lines) {
  Node most = Node::Zero();
  for (size_t i = 0; i < lines.outer; ++i) {
    const Node* line = nodes + i * lines.count * lines.inner;
    for (size_t k = lines.inner; k < (lines.count - 1) * lines.inner; ++k)
      most = most.max(((line[k - lines.inner] + line[k + lines.inner]) - 2 * line[k]).abs());
  }
  return most;
}

// At Along::place of each line, straight between nodes.
void straighten(const Node* nodes, const Lines& lines, const Along& along, Node* out) {
  const int places = along.places();
  for (int p = 0; p < places; ++p) {
    const double place = along.place(p);
    const size_t base = std::min(static_cast<size_t>(place), lines.count - 2);
    const auto t = static_cast<float>(place - static_cast<double>(base));
    for (size_t i = 0; i < lines.outer; ++i) {
      const Node* below = nodes + (i * lines.count + base) * lines.inner;
      Node* to = out + (i * static_cast<size_t>(places) + static_cast<size_t>(p)) * lines.inner;
      for (size_t k = 0; k < lines.inner; ++k) to[k] = below[k] + t * (below[k + lines.inner] - below[k]);
    }
  }
}

}  // namespace

bool DisplacementField::bounds(Coord first, int edge, Vec3f& low, Vec3f& high) const {
  Along along[3];
  int n = 0;
  for (int axis = 0; axis < 3; ++axis) {
    const int voxel = (axis == 0 ? first.x : axis == 1 ? first.y : first.z) * kBrickEdge;
    const auto node = [&](int at) { return (at - 0.5 * (spacing_ - 1)) / spacing_; };
    const double begin = node(voxel - 1), end = node(voxel + kBrickEdge * edge);
    Along& one = along[axis];
    // Cubics reach a node beyond those that they lie between; with a node at each voxel there are none.
    const int beyond = spacing_ > 1 ? 1 : 0;
    one.from = static_cast<int>(std::floor(begin)) - beyond;
    one.low = begin - one.from;
    one.high = end - one.from;
    n = std::max(n, static_cast<int>(std::floor(end)) + 1 + 2 * beyond - one.from);
  }
  const auto side = static_cast<size_t>(n), count = side * side * side;
  thread_local std::vector<Displacement> window;
  if (window.size() < count) window.resize(count);
  if (!gather({along[0].from, along[1].from, along[2].from}, n, window.data())) return false;
  const auto node = [&](size_t i) { return Eigen::Map<const Node, Eigen::Aligned16>(&window[i].x); };
  Node least = node(0), most = least;
  for (size_t i = 1; i < count; ++i) {
    least = least.min(node(i));
    most = most.max(node(i));
  }
  if ((least == 0).all() && (most == 0).all()) return false;
  if (spacing_ < kTightFrom) {
    // Three cubics one after the other overshoot by less than half of the range.
    const Node over = (most - least) * (spacing_ > 1 ? 0.5f : 0.0f);
    low = (least - over).head<3>().matrix();
    high = (most + over).head<3>().matrix();
    return true;
  }
  thread_local std::vector<Node> one, other;
  if (one.size() < count) {
    one.resize(count);
    other.resize(count);
  }
  for (size_t i = 0; i < count; ++i) one[i] = node(i);
  // A cubic is off from the straight line between two nodes by an eighth of the larger second difference beside them at
  // most, and carries on what it is given by 1.25 at most.
  constexpr float kCubic = 1.25f;
  const Node* nodes = one.data();
  const Node bends = mostBend(nodes, {1, side, side * side}) +
                     kCubic * (mostBend(nodes, {side, side, side}) + kCubic * mostBend(nodes, {side * side, side, 1}));
  const Node off = 0.01f + bends / 8;
  // x, y, z, one after the other.
  const auto xs = static_cast<size_t>(along[0].places()), ys = static_cast<size_t>(along[1].places()),
             zs = static_cast<size_t>(along[2].places());
  straighten(one.data(), {1, side, side * side}, along[0], other.data());
  straighten(other.data(), {xs, side, side}, along[1], one.data());
  straighten(one.data(), {xs * ys, side, 1}, along[2], other.data());
  least = most = other[0];
  for (size_t i = 1; i < xs * ys * zs; ++i) {
    least = least.min(other[i]);
    most = most.max(other[i]);
  }
  low = (least - off).head<3>().matrix();
  high = (most + off).head<3>().matrix();
  return true;
}

bool DisplacementField::atVoxels(Coord brick, Displacement (&out)[1000]) const {
  const Refinement r = refinement(brick);
  if (spacing_ == 1) return gather(r.first, r.n, out);
  Displacement* nodes = scratchNodes();
  if (!gather(r.first, r.n, nodes)) return false;
  refineDisplacements(nodes, r.n, r.base, r.weights, nodes + kMostNodes * kMostNodes * kMostNodes, out);
  return true;
}

DisplacementField DisplacementField::refined() const {
  DisplacementField fine(spacing_ / 2);
  // A fine node lies a quarter of a spacing beside a coarse one.
  float up[4], down[4];
  cubicWeights(0.25f, up);
  cubicWeights(0.75f, down);
  int base[3][10];
  float weights[3][10][4];
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < 10; ++i) {
      // Fine node i − 1 of a block that begins with an even coarse node.
      const int coarse = (i - 1 + 2) / 2 - 1;
      const bool upper = (i - 1) & 1;
      base[axis][i] = coarse - (upper ? 1 : 2) + 3;
      std::copy(upper ? up : down, (upper ? up : down) + 4, weights[axis][i]);
    }
  std::vector<Displacement> window(11 * 11 * 11), scratch(11 * 11 * 20 + 11 * 200);
  Displacement out[1000];
  BrickSet targets;
  for (const auto& entry : blocks_)
    for (int i = 0; i < 64; ++i) targets.add(entry.first * 2 + Coord{(i >> 4) - 1, ((i >> 2) & 3) - 1, (i & 3) - 1});
  for (const Coord block : targets.sorted()) {
    if (!gather(block * 4 - Coord{3, 3, 3}, 11, window.data())) continue;
    refineDisplacements(window.data(), 11, base, weights, scratch.data(), out);
    auto nodes = std::make_unique<Block>();
    for (int x = 0; x < 8; ++x)
      for (int y = 0; y < 8; ++y)
        std::copy_n(out + ((x + 1) * 10 + y + 1) * 10 + 1, 8, nodes->node + Brick::offset(x, y, 0));
    fine.blocks_.emplace(block, std::move(nodes));
  }
  return fine;
}

}  // namespace argil::clay
