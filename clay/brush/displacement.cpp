#include "clay/brush/displacement.h"

#include <algorithm>
#include <cmath>
#include <cstring>

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

bool DisplacementField::bounds(Coord brick, Vec3f& low, Vec3f& high) const {
  const Refinement r = refinement(brick);
  Displacement* nodes = scratchNodes();
  if (!gather(r.first, r.n, nodes)) return false;
  Eigen::Array4f least = Eigen::Array4f::Zero(), most = least;
  const int count = r.n * r.n * r.n;
  least = most = Eigen::Map<const Eigen::Array4f>(&nodes[0].x);
  for (int i = 1; i < count; ++i) {
    const Eigen::Map<const Eigen::Array4f> node(&nodes[i].x);
    least = least.min(node);
    most = most.max(node);
  }
  if ((least == 0).all() && (most == 0).all()) return false;
  // Three cubics one after the other overshoot by less than half of the range.
  const Eigen::Array4f over = (most - least) * (spacing_ > 1 ? 0.5f : 0.0f);
  low = (least - over).head<3>().matrix();
  high = (most + over).head<3>().matrix();
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
