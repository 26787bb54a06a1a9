#pragma once
// A version's tree as those see it who keep versions elsewhere: read-only.

#include <cstdint>

#include "clay/kernels/brick.h"
#include "clay/store/version.h"

namespace argil::clay {

/// A block of 8^level bricks along each axis, and what stands there: a tile, a node with 512 children, or (level 0) a
/// brick. Valid as long as the version is pinned. Any thread. A copy is a few words.
class TreePlace {
 public:
  /// All that a version can reach: of its distances, or of a channel, where a tile is 0 (outside) or 255 (inside)
  /// everywhere.
  [[nodiscard]] static TreePlace root(const Version& version);
  [[nodiscard]] static TreePlace root(const Version& version, Channel channel);

  [[nodiscard]] int level() const { return level_; }    ///< kTreeLevels to 0.
  [[nodiscard]] Coord first() const { return first_; }  ///< Its first brick coordinate; it may lie out of reach.
  [[nodiscard]] bool isTile() const { return link_ <= 1; }
  [[nodiscard]] Tile tile() const { return static_cast<Tile>(link_); }
  [[nodiscard]] bool isNode() const { return !isTile() && level_ > 0; }
  /// The brick, or null: of a tree of distances, or of a channel.
  [[nodiscard]] const Brick* brick() const {
    return isTile() || level_ > 0 ? nullptr : reinterpret_cast<const Brick*>(link_);
  }
  [[nodiscard]] const ChannelBrick* channelBrick() const {
    return isTile() || level_ > 0 ? nullptr : reinterpret_cast<const ChannelBrick*>(link_);
  }

  /// Of a node: names what stands in it for good, in all of the process. Versions that share it have it at the same
  /// address.
  struct Identity {
    uint64_t address = 0, birth = 0;
    friend bool operator==(const Identity&, const Identity&) = default;
  };
  [[nodiscard]] Identity identity() const;

  /// Child (x·64 + y·8 + z) of a place above level 0; of a tile: the same tile.
  [[nodiscard]] TreePlace child(int index) const;

 private:
  [[nodiscard]] static TreePlace rootOfTree(const Version& version, int tree);

  uintptr_t link_ = 0;
  Coord first_;
  int level_ = 0;
};

/// The first brick coordinate of a version's tree.
[[nodiscard]] Coord treeFirst();
/// That of a node's child.
[[nodiscard]] inline Coord childFirst(Coord first, int level, int index) {
  return first + Coord{index >> 6, (index >> 3) & 7, index & 7} * (1 << (3 * (level - 1)));
}

}  // namespace argil::clay
