#pragma once
// Clay versions as records, which share on disk what versions share in memory.

#include <algorithm>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "clay/base/job.h"
#include "clay/store/tree_view.h"
#include "clay/store/version.h"
#include "io/records/id_table.h"
#include "io/records/record.h"

namespace argil::io {

/// What a damaged file still has of a clay: bricks of all its versions.
class OlderBricks {
 public:
  virtual ~OlderBricks() = default;
  /// Calls back with each brick record of this owner whose place lies in the block of `edge` bricks along each axis
  /// from `first`, in any order: (brick coordinate, id). What is there may be damaged.
  virtual void bricksIn(uint32_t owner, Coord first, int32_t edge,
                        const std::function<void(Coord, RecordId)>& each) const = 0;
};

/// Gives out ids.
class RecordIds {
 public:
  explicit RecordIds(RecordId next = 1) : next_(next) {}
  /// The first of `count` ids in a row.
  RecordId take(uint64_t count = 1) { return std::exchange(next_, next_ + count); }
  void atLeast(RecordId next) { next_ = std::max(next_, next); }
  [[nodiscard]] RecordId next() const { return next_; }

 private:
  RecordId next_;
};

struct ClayHead;  // io/records/channel_codec.h

/// Reading a version back.
struct ReadClay {
  clay::Version version;
  /// Not there or damaged; with `repair` their place was filled from older or neighbouring clay.
  uint64_t bricksLost = 0;
  uint64_t blocksLost = 0;         ///< The same of nodes: what lay under them is not counted.
  std::vector<std::string> notes;  ///< Sentences on what was lost.
};

/// A version's bricks are at most so many when it is read (36 GB).
inline constexpr uint64_t kMostBricks = uint64_t{1} << 24;

/// Knows which record holds what of the clay in memory, for all files of one document: bricks by their serial, nodes by
/// address and birth (an address is reused, never with the same birth). One thread at a time; the versions that are
/// passed in are pinned by the caller during the call.
class ClayRecords {
 public:
  explicit ClayRecords(RecordIds& ids) : ids_(ids) {}

  /// Puts what of `version`, its channels included, is not in `held` yet into the sink, children before parents, adds
  /// it to `held`, returns the id of its root (the same id for the same version, whatever file it goes to). Whoever
  /// holds a node holds all under it. Cost follows what is new. `codec` for bricks: raw where time counts, predicted
  /// for files that stay (clay_records.md has the figures). `owner` names the clay in the document: the same for all
  /// versions of one store. Throws what the sink throws, Cancelled; then `held` may hold ids that the file lost: the
  /// caller who rolls back restores its copy.
  RecordId write(const clay::Version& version, uint32_t owner, RecordSet& held, RecordSink& sink, RecordCodec codec,
                 Job* job = nullptr);

  /// The id that write() or a reading gave this version; 0 when neither has seen it.
  [[nodiscard]] RecordId rootOf(const clay::Version& version, uint32_t owner) const {
    return nodes_.find(keyOf(version, owner));
  }

  /// The version with this root, in `store`, which nobody else edits meanwhile. Throws Error (kind work, "damaged:
  /// ...") when a record is missing or damaged, unless there is a `repair`: then what is lost is taken from older
  /// records of the same owner and place, or from the clay around it, and told; the surface is closed in any case, and
  /// colours, materials and masks that are lost are unset. Throws Cancelled, Error for a bad grid and for more than
  /// kMostBricks. `threads` for unpacking, 1 to 64. `owner`: records of another clay are damaged; 0 when it is not
  /// known, but then nothing can be repaired whose root is lost.
  ReadClay read(RecordSource& source, RecordId root, const clay::Grid& grid, std::shared_ptr<clay::Store> store,
                Job* job = nullptr, int threads = 2, const OlderBricks* repair = nullptr, uint32_t owner = 0);
  /// The same in the store of `near`, whose root is `nearRoot`: all that both have in common is shared, and the cost
  /// follows the difference. Both roots are in the source.
  ReadClay readNear(RecordSource& source, RecordId root, const clay::Version& near, RecordId nearRoot,
                    Job* job = nullptr);

  /// Takes over what another one knows, such as one that another thread has read with.
  void learn(const ClayRecords& other);
  /// Forgets what no version in use has: `inUse` are all that may be written again. Cost O(entries that stay).
  void forgetUnused(std::span<const clay::Version> inUse);
  /// Versions with channels, nodes and bricks known.
  [[nodiscard]] size_t entries() const { return nodes_.size() + bricks_.size(); }

 private:
  friend class ClayReading;
  friend class ChannelReading;
  friend struct ClayWriting;
  struct NodeKey {
    clay::TreePlace::Identity node;
    [[nodiscard]] uint64_t hash() const { return mixed(node.address ^ mixed(node.birth)); }
    friend bool operator==(const NodeKey&, const NodeKey&) = default;
  };
  struct BrickKey {
    uint64_t serial = 0;
    [[nodiscard]] uint64_t hash() const { return mixed(serial); }
    friend bool operator==(const BrickKey&, const BrickKey&) = default;
  };
  // A version that is one tile has no node: its key is what no node can have.
  static NodeKey keyOf(const clay::TreePlace& place, uint32_t owner) {
    return {place.isTile() ? clay::TreePlace::Identity{static_cast<uint64_t>(place.tile()), owner} : place.identity()};
  }
  // Of a whole version: of its distances' root, or where it has channels a hash of all roots, odd as no address is.
  [[nodiscard]] static NodeKey keyOf(const clay::Version& version, uint32_t owner);
  void readChannels(RecordSource& source, const ClayHead& head, const ClayHead& nearHead, const clay::Version& near,
                    RecordId root, uint32_t owner, bool repairing, Job* job, ReadClay& read);

  RecordIds& ids_;
  IdTable<NodeKey> nodes_;
  IdTable<BrickKey> bricks_;
};

/// The ids of all records that the tree under `root` consists of, added to `live`. Nodes already in `live` are not
/// walked again. Throws Error (kind work) when a node is missing or damaged: then nobody knows what is live.
void markLive(RecordSource& source, RecordId root, RecordSet& live);

}  // namespace argil::io
