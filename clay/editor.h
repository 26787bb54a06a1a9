#pragma once
// Builds the next version from one that stays as it is.

#include <cstdint>
#include <span>
#include <vector>

#include "clay/version.h"

namespace argil::clay {

/// What a kernel knows about a brick it has just written.
struct BrickState {
  bool inBand = false;  ///< Some |phi| < band: the brick must exist.
};

/// One writer's transaction on a version: reads see the edits so far; commit() yields a new version that shares every
/// untouched brick and node with the base. Bricks made in this transaction are written in place. One thread; at most one
/// editor at a time per store. Destroyed without commit: the base is untouched, all is given back.
class Editor {
 public:
  explicit Editor(Version base);
  ~Editor();
  Editor(const Editor&) = delete;
  Editor& operator=(const Editor&) = delete;

  [[nodiscard]] const Version& base() const { return base_; }
  [[nodiscard]] const Grid& grid() const { return base_.grid(); }

  /// What stands at a brick coordinate now, edits included.
  [[nodiscard]] Slot find(Coord brick) const noexcept;

  /// Replaces the content of a brick coordinate by 512 distances in voxels (Brick's order). Clamps to ±band, turns −0 to 0,
  /// drops the brick to a tile where no |phi| < band. Equal content keeps the old brick. Throws Error for NaN or out of reach.
  void setVoxels(Coord brick, std::span<const float, kBrickVoxels> phi);
  /// Makes a brick coordinate a tile.
  void setTile(Coord brick, Tile tile);
  /// Makes all 8^(3·level) bricks of the aligned block that holds `brick` one tile (level 1: 8×8×8 bricks). O(1).
  void setBlock(Coord brick, int level, Tile tile);

  // For kernels: a brick that is filled first and linked afterwards.
  [[nodiscard]] Brick* newBrick(Coord brick);  ///< Uninitialised phi and inside; the editor owns it until linked or recycled.
  void recycle(Brick* brick);
  /// Links a filled brick (clamped, no NaN or −0, inside bits right). `inBand` false: becomes the tile of its first voxel.
  void link(Brick* brick, bool inBand);
  /// The brick at a coordinate when this transaction made it (it may be written in place), else null.
  [[nodiscard]] Brick* own(Coord brick) noexcept;

  /// The new version; the editor is finished. Without any change: the base itself.
  [[nodiscard]] Version commit();

  struct Counts {
    uint64_t bricksMade = 0, nodesMade = 0;
    [[nodiscard]] uint64_t bytes() const;
  };
  [[nodiscard]] Counts counts() const { return counts_; }

 private:
  struct Path;
  Node* writableRegion(Coord brick);
  Version base_;
  Store* store_;
  Node* root_;       // committed as the new root; equals the base's until the first change
  uint64_t id_;
  int64_t bricksDelta_ = 0, nodesDelta_ = 0;
  Counts counts_;
  Coord cachedRegion_{INT32_MIN, 0, 0};
  Node* cachedNode_ = nullptr;
  std::vector<Coord> regionsTouched_;
  bool changed_ = false;
};

}  // namespace argil::clay
