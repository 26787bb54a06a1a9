#pragma once
// Where the clay of a stroke came from: displacements composed stamp by stamp. This module's own.

#include <memory>
#include <span>
#include <unordered_map>

#include "clay/kernels/brick.h"
#include "clay/kernels/warp_kernels.h"
#include "clay/store/brick_set.h"

namespace argil::clay {

/// Vectors from a place to where its clay was when the stroke began, voxels, at nodes `spacing` voxels apart (a power
/// of two): zero where nothing moved. Nodes lie in the middle of spacing³ voxels, so that mirror images in planes
/// between bricks have mirrored nodes (spacing 8 at most).
class DisplacementField {
 public:
  explicit DisplacementField(int spacing) : spacing_(spacing) {}

  [[nodiscard]] int spacing() const { return spacing_; }

  /// One of `images` for the block at `block`, whose nodes are those from 8 · block on.
  [[nodiscard]] Vec3d middle(Coord block) const {
    return (block * (kBrickEdge * spacing_)).toVec3d() + Vec3d::Constant(4.0 * spacing_ - 0.5);
  }

  /// D(x) becomes D(origin(x)) + origin(x) − x in `blocks` (each once): trace(block, places) fills where the nodes'
  /// clay was before, relative to middle(block), at most `most` voxels away.
  template <class Trace>
  void compose(std::span<const Coord> blocks, double most, const Trace& trace) {
    const int margin = static_cast<int>(most / spacing_) + 3;
    prepare(margin);
    fresh_.clear();
    for (const Coord block : blocks) {
      trace(block, *places_);
      gather(block * kBrickEdge - Coord{margin, margin, margin}, kBrickEdge + 2 * margin, window_.get());
      fresh_.emplace_back(block, std::make_unique<Block>());
      composeDisplacements(*places_, static_cast<float>(spacing_), window_.get(), margin, fresh_.back().second->node);
    }
    // Placed once all have been computed: every block comes from the field as it was before.
    for (auto& [block, nodes] : fresh_) blocks_[block] = std::move(nodes);
  }

  /// Bounds, along each axis, of the displacements in a cube of bricks and one voxel around it. False where all are
  /// zero.
  [[nodiscard]] bool bounds(Coord first, int edge, Vec3f& low, Vec3f& high) const;

  /// Displacements at the voxels of a brick and one around it, [x][y][z] at (x·10 + y)·10 + z. False where all are
  /// zero; then nothing is written.
  [[nodiscard]] bool atVoxels(Coord brick, Displacement (&out)[1000]) const;

  /// The same field with nodes twice as dense.
  [[nodiscard]] DisplacementField refined() const;

  [[nodiscard]] size_t size() const { return blocks_.size(); }  ///< Blocks that it holds.
  /// The longest displacement at the nodes of a block; along the axis where it is longest.
  [[nodiscard]] float farthest(Coord block) const;

 private:
  struct Block {
    Displacement node[kBlockNodes];
  };
  // Nodes that the voxels of a brick and one around it are interpolated from, and how.
  struct Refinement {
    int base[3][10];
    float weights[3][10][4];
    Coord first;
    int n = 0;
  };
  [[nodiscard]] Refinement refinement(Coord brick) const;
  void prepare(int margin);
  bool gather(Coord firstNode, int n, Displacement* window) const;

  int spacing_;
  std::unordered_map<Coord, std::unique_ptr<Block>, CoordHash> blocks_;
  std::unique_ptr<Displacement[]> window_;
  std::unique_ptr<NodePlaces> places_ = std::make_unique<NodePlaces>();
  std::vector<std::pair<Coord, std::unique_ptr<Block>>> fresh_;
  int margin_ = 0;
};

}  // namespace argil::clay
