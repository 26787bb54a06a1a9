#pragma once
// Builds the next version from one that stays as it is.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "clay/store/object_stock.h"
#include "clay/store/version.h"

namespace argil::clay {

/// One writer's transaction on a version: reads see the edits so far; commit() yields a new version that shares every
/// untouched brick and node with the base. Bricks made in this transaction are written in place. One thread; a store
/// may have several editors at once. Destroyed without commit: the base is untouched, all is given back.
class Editor {
 public:
  explicit Editor(Version base);
  ~Editor();
  Editor(const Editor&) = delete;
  Editor& operator=(const Editor&) = delete;

  [[nodiscard]] const Version& base() const { return base_; }
  [[nodiscard]] const Grid& grid() const { return base_.grid(); }

  [[nodiscard]] float step() const { return step_; }  ///< Of its bricks (Brick::step).

  /// What stands at a brick coordinate now, edits included. Out of reach: Tile::outside. Any threads while none edits.
  /// In the region (8×8×8 bricks) that was edited last it costs one load, else as many as the tree has levels; Sampler
  /// remembers where it was.
  [[nodiscard]] Slot find(Coord brick) const noexcept;

  /// Replaces the content of a brick coordinate by 512 distances in voxels (Brick's order). Clamps to ±band, turns −0
  /// to 0, becomes a tile where no |phi| < band. Equal content keeps the old brick. Throws Error for NaN or out of
  /// reach.
  void setVoxels(Coord brick, std::span<const float, kBrickVoxels> phi);
  /// Makes a brick coordinate a tile. Throws Error out of reach.
  void setTile(Coord brick, Tile tile);
  /// Equal values keep the old brick; all 0 or all 255 become a tile. Throws Error out of reach.
  void setChannel(Channel channel, Coord brick, std::span<const uint8_t, kBrickVoxels> values);
  void setChannelTile(Channel channel, Coord brick, bool full);
  [[nodiscard]] ChannelSlot find(Channel channel, Coord brick) const noexcept;
  [[nodiscard]] bool has(Channel channel) const noexcept;

  /// Makes the tree's block of 8^level bricks along each axis that holds `brick` one tile (level 0 to kTreeLevels).
  /// Blocks of level 1 start at multiples of eight bricks, larger ones where blockFirst() says. Cost follows what stood
  /// there. False when it was that tile already. Throws Error out of reach.
  bool setBlock(Coord brick, int level, Tile tile);
  /// The first brick coordinate of that block; it may lie out of reach.
  [[nodiscard]] static Coord blockFirst(Coord brick, int level);

  // For kernels: a brick is filled first and linked afterwards.

  /// Brick with uninitialised value and inside; give it to link() or recycle(). Where the store's bricks are fixed it
  /// is one on its way: link() packs it.
  [[nodiscard]] FloatBrick* newBrick(Coord brick);
  /// Puts a filled brick (clamped, no NaN or −0, inside bits right, in reach) in its place. `inBand`, some |phi| <
  /// band; when false it becomes the tile of its first voxel's sign. A brick that own() gave is linked again after
  /// writing in place. What is the same in the store's precision keeps the old brick.
  void link(FloatBrick* brick, bool inBand);
  /// The same in the form of the store: where memory counts, as all bricks of a file are there before they are linked.
  [[nodiscard]] Brick* newStoredBrick(Coord brick);
  void recycle(Brick* brick);
  void link(Brick* brick);
  /// The brick at a coordinate if this transaction made it and it is a FloatBrick, so that it may be written in place;
  /// else null.
  [[nodiscard]] FloatBrick* own(Coord brick) noexcept;

  /// The new version; the editor is finished. Without any change: the base itself.
  [[nodiscard]] Version commit();

  struct Counts {
    uint64_t bricksMade = 0, nodesMade = 0, channelBricksMade = 0;
    Precision precision = Precision::float32;
    [[nodiscard]] uint64_t bytes() const;
  };
  /// What this transaction took from the store so far.
  [[nodiscard]] Counts counts() const { return counts_; }

 private:
  friend class Sampler;
  struct Tree {
    uintptr_t root = 0;
    bool distances = false;               // its leaves are Bricks, else ChannelBricks
    std::vector<Coord> mayCollapse;       // a brick coordinate in each region that got a tile
    Coord cachedRegion{INT32_MIN, 0, 0};  // the one that was written last
    uintptr_t cachedLink = 0;
  };
  [[nodiscard]] uintptr_t linkAt(const Tree& tree, Coord brick) const noexcept;
  [[nodiscard]] uintptr_t* writableLink(Tree& tree, Coord brick, int level);
  [[nodiscard]] Node* newNode(uintptr_t fill);
  [[nodiscard]] Node* takeNode();
  [[nodiscard]] ChannelBrick* takeChannelBrick();
  void giveBack();
  [[nodiscard]] uint64_t nextSerial();
  template <class Form>
  [[nodiscard]] Form* prepared(ObjectStock& stock, Coord brick, float step);
  void pack(FloatBrick* brick, bool inBand);
  void release(const Tree& tree, uintptr_t link, int level);
  void collapse(Tree& tree, Coord brick);
  void place(Tree& tree, Coord brick, uintptr_t link);
  [[nodiscard]] Tree& treeOfChannel(Channel channel) { return trees_[1 + static_cast<size_t>(channel)]; }
  [[nodiscard]] const Tree& treeOfChannel(Channel channel) const { return trees_[1 + static_cast<size_t>(channel)]; }

  struct Stock {
    ObjectStock bricks, channelBricks, nodes;
    ObjectStock work;  // bricks of floats, where the store's are fixed
  };

  Version base_;
  Stock stock_;
  Store* store_;
  uint64_t id_;
  float step_;
  std::array<Tree, 1 + kChannels> trees_;  // distances first
  int64_t bricksDelta_ = 0, nodesDelta_ = 0, channelDelta_ = 0;
  Counts counts_;
  bool changed_ = false;
  uint64_t serial_ = 0, serialEnd_ = 0;
};

}  // namespace argil::clay
