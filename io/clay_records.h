#pragma once
// Clay versions as records, which share on disk what versions share in memory.

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "clay/job.h"
#include "clay/version.h"
#include "io/record.h"

namespace argil::io {

class Salvage;

/// Gives out ids.
class RecordIds {
 public:
  explicit RecordIds(RecordId next = 1) : next_(next) {}
  RecordId take() { return next_++; }
  void atLeast(RecordId next) { next_ = std::max(next_, next); }
  [[nodiscard]] RecordId next() const { return next_; }

 private:
  RecordId next_;
};

/// Reading a version back.
struct ReadClay {
  clay::Version version;
  uint64_t bricksLost = 0;        ///< Not there or damaged; with `mend` their place was filled from older or neighbouring clay.
  std::vector<std::string> notes; ///< Sentences on what was lost.
};

/// Knows which record holds what of the clay in memory, for all files of one document: bricks by their serial, nodes by address and birth (an address is
/// reused, never with the same birth). One thread at a time; the versions that are passed in are pinned by the caller during the call.
class ClayRecords {
 public:
  explicit ClayRecords(RecordIds& ids) : ids_(ids) {}

  /// Puts what of `version` is not in `held` yet into the sink, children before parents, adds it to `held`, returns the id of its root (the same
  /// id for the same version, whatever file it goes to). Cost follows what is new. `codec` for bricks: raw is 0.3 µs a brick, zstd is for files that
  /// stay. `owner` names the clay in the document: the same for all versions of one store. Throws what the sink throws, Cancelled; then `held` may hold ids that the file lost: the caller who rolls
  /// back restores its copy.
  RecordId write(const clay::Version& version, uint32_t owner, RecordSet& held, RecordSink& sink, RecordCodec codec, Job* job = nullptr);

  /// The version with this root, in a store of its own or that of `near`: with `near`, whose root is `nearRoot`, all that both have in common is shared and the cost
  /// follows the difference. Throws Error (kind work, "damaged: ...") when a record is missing or damaged, unless there is a `mend`: then what is lost is
  /// taken from older records of the same owner and place, or from the clay around it, and told. Cancelled. `threads` for unpacking.
  ReadClay read(RecordSource& source, RecordId root, const clay::Grid& grid, std::shared_ptr<clay::Store> store, Job* job = nullptr, int threads = 2,
                const Salvage* mend = nullptr);
  ReadClay readNear(RecordSource& source, RecordId root, const clay::Version& near, RecordId nearRoot, Job* job = nullptr);

  /// Forgets what no version in use has: `inUse` are all that may be written again. Cost O(entries + new walk).
  void forgetUnused(std::span<const clay::Version> inUse);
  [[nodiscard]] size_t entries() const;

 private:
  RecordIds& ids_;
};

/// The ids of all records that the tree under `root` consists of, added to `live`. Nodes already in `live` are not walked again.
void markLive(RecordSource& source, RecordId root, RecordSet& live);

}  // namespace argil::io
