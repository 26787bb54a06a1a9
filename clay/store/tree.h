#pragma once
// Inside of a version: the tree of nodes. For this module's files alone; others read through Version and Sampler.

#include <algorithm>
#include <array>
#include <atomic>
#include <mutex>
#include <utility>
#include <vector>

#include "clay/store/object_stock.h"
#include "clay/store/store.h"
#include "clay/store/version.h"

namespace argil::clay {

/// 0 or 1: a Tile; else the address of a Node (levels 5 to 2) or of a Brick (level 1's children).
using Link = uintptr_t;

inline constexpr bool isTile(Link link) {
  return link <= 1;
}
inline constexpr Link linkOf(Tile tile) {
  return static_cast<Link>(tile);
}

/// 8×8×8 children. A node of level 1 (a region, 64 voxels wide) holds bricks, the root is of level kTreeLevels.
struct alignas(64) Node {
  uint64_t birth;  ///< Id of the version that made it: only that version's editor may write it.
  Link child[512];
};

/// Added to a brick coordinate before its digits to base eight say the way through the tree. Level 1 starts at
/// multiples of eight bricks; above it zero lies in the middle of a node, so that a model around the origin shares one
/// path.
inline constexpr int kBrickOrigin = 044440;

/// Child index, within a node of `level`, on the way to a brick.
inline int childIndex(Coord brick, int level) {
  const int shift = 3 * (level - 1);
  const auto digit = [shift](int32_t c) {
    return static_cast<int>((static_cast<uint32_t>(c + kBrickOrigin) >> shift) & 7u);
  };
  return (digit(brick.x) << 6) | (digit(brick.y) << 3) | digit(brick.z);
}

inline bool inReach(Coord b) {
  const auto in = [](int32_t c) { return c >= -kBrickReach && c < kBrickReach; };
  return in(b.x) && in(b.y) && in(b.z);
}

/// The link at level `stop` on the way to a brick (0: the brick itself); a tile met earlier is returned as it is.
inline Link descend(Link root, Coord brick, int stop) noexcept {
  Link link = root;
  for (int level = kTreeLevels; level > stop; --level) {
    if (isTile(link)) return link;
    link = reinterpret_cast<const Node*>(link)->child[childIndex(brick, level)];
  }
  return link;
}

inline Slot slotOf(Link link) {
  return isTile(link) ? Slot(static_cast<Tile>(link)) : Slot(reinterpret_cast<const Brick*>(link));
}

/// Trees of a version: distances, then the channels.
inline constexpr int kTrees = 1 + kChannels;
inline constexpr int kDistanceTree = 0;
inline constexpr int treeOf(Channel channel) {
  return 1 + static_cast<int>(channel);
}

inline ChannelSlot channelSlotOf(Link link) {
  return isTile(link) ? ChannelSlot(link == 1) : ChannelSlot(reinterpret_cast<const ChannelBrick*>(link));
}

struct VersionRecord {
  std::shared_ptr<Store> store;
  Grid grid;
  float step = 0;  // of its bricks
  uint64_t id = 0;
  std::array<Link, kTrees> roots{};
  VersionStats stats;
  // The tree of versions, guarded by the store's mutex: what a dropped version may free is what neither its parent nor
  // its child has at the same place.
  VersionRecord* parent = nullptr;
  std::vector<VersionRecord*> children;
  bool isMade = false;  // the store knows of it
};

inline Link rootOf(const VersionRecord& record, Channel channel) {
  return record.roots[static_cast<size_t>(treeOf(channel))];
}

/// Memory of equal-sized objects in pre-touched chunks, which are small while there is little: a document may have a
/// thousand pieces. From 16 MB on they are huge pages. Guarded by the store's mutex, but for map().
class SlabPool {
 public:
  explicit SlabPool(size_t objectBytes) : objectBytes_(objectBytes) {}
  ~SlabPool();
  SlabPool(const SlabPool&) = delete;
  SlabPool& operator=(const SlabPool&) = delete;

  struct Chunk {
    std::byte* at = nullptr;
    size_t bytes = 0;
  };

  /// Moves `count` free objects to `stock`, taking chunks as needed.
  void take(size_t count, ObjectStock& stock);
  /// Needs no memory: there is room for every object that the pool has.
  void give(const std::vector<void*>& objects) noexcept { free_.insert(free_.end(), objects.begin(), objects.end()); }
  [[nodiscard]] uint64_t bytes() const { return bytes_; }
  [[nodiscard]] uint64_t heapBytes() const;

  /// In use and nearly empty: the next objects would wait for the system.
  [[nodiscard]] bool low() const { return bytes_ > 0 && free_.size() * objectBytes_ < nextBytes(); }
  /// Bytes that are missing of what was taken since this was asked last (32 MB of it at most, which a stamp of radius
  /// 200 may take), or of a chunk where that is more.
  [[nodiscard]] size_t missing() {
    const size_t again = std::min(std::exchange(taken_, 0) * objectBytes_, kMostSpare);
    const size_t wanted = std::max(nextBytes(), again);
    return bytes_ > 0 ? wanted - std::min(wanted, free_.size() * objectBytes_) : 0;
  }
  /// What the next chunk is to have: an eighth of what there is, so that what is not used is little beside the rest.
  [[nodiscard]] size_t nextBytes() const;
  /// A new chunk, every page of it touched (which can take milliseconds). Any thread, without the store's mutex.
  [[nodiscard]] Chunk map(size_t bytes);
  void adopt(Chunk chunk);

 private:
  static constexpr size_t kSlabBytes = size_t{2} << 20;    // one huge page
  static constexpr size_t kArenaBytes = size_t{64} << 20;  // address space taken at once, touched slab by slab
  static constexpr size_t kMostSpare = size_t{32} << 20;
  static constexpr size_t kLeastObjects = 6;  // of a chunk

  size_t objectBytes_;
  std::vector<void*> free_;
  uint64_t bytes_ = 0;
  size_t taken_ = 0;  // objects, since missing() was asked
  mutable std::mutex arenaMutex_;
  std::vector<std::byte*> arenas_;  // as mapped: kArenaBytes + kSlabBytes for alignment
  std::vector<std::byte*> small_;   // chunks below a slab
  size_t slabsInArena_ = 0;
};

struct Store::State {
  explicit State(Precision how) : precision(how) {}
  std::mutex mutex;
  const Precision precision;
  SlabPool bricks{brickBytes(precision)};
  SlabPool workBricks{sizeof(FloatBrick)};  // of editors whose bricks are fixed
  SlabPool nodes{sizeof(Node)};
  SlabPool channelBricks{sizeof(ChannelBrick)};
  uint64_t liveBricks = 0, liveNodes = 0, liveChannelBricks = 0;
  std::vector<VersionRecord*> dropped;  // waiting for collect()
  uint64_t versions = 0;
  std::atomic<bool> due{false};  // a version was dropped, or a pool runs low, since collect() looked last
  bool collected = false;        // once at least: what was taken before that is a model's birth
  bool taken = false;            // by an editor, since then

  // Of all stores together: savers know bricks by serial and nodes by address and birth, and a store may take over the
  // addresses of one that is gone.
  static inline std::atomic<uint64_t> nextId{1};
  static inline std::atomic<uint64_t> nextSerial{1};

  // A collection in progress: what is being walked, and where.
  struct Frame {
    Link own, before, after;  // the same place in the dropped version, its parent and its child
    int level;
    int next;
  };
  std::mutex collecting;
  VersionRecord* victim = nullptr;
  std::vector<Frame> walk;
  int victimTree = kTrees;  // the next of its trees to be walked

  /// Moves some of a kind to an editor's own stock, so that it locks once in a while.
  void stockBricks(ObjectStock& stock);
  void stockNodes(ObjectStock& stock);
  void stockWorkBricks(ObjectStock& stock);
  void giveWorkBricks(const std::vector<void*>& stock);
  void stockChannelBricks(ObjectStock& stock);

  struct Freed {
    std::vector<void*> bricks, channelBricks, nodes;
    /// Where leaves of a tree go.
    [[nodiscard]] std::vector<void*>& leaves(int tree) { return tree == kDistanceTree ? bricks : channelBricks; }
  };
  void freeAll(Freed& freed);

 private:
  /// So many at a time of a pool that has `live` of them: an eighth, as what an editor does not use lies idle.
  static size_t stockOf(uint64_t live, size_t most);
};

/// Collects into `leaves` and `nodes` what `own` uses at places where neither `before` nor `after` uses the same.
void gatherExclusive(Link own, Link before, Link after, int level, std::vector<void*>& leaves,
                     std::vector<void*>& nodes);

/// Hands out a record as a version whose last handle gives it to the store's collector. When it throws, nothing was
/// made of the record's trees.
Version makeVersion(std::unique_ptr<VersionRecord> record);

}  // namespace argil::clay
