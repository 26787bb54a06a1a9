#pragma once
// How the channels of a version come out of their records. For this module's files alone.

#include <map>
#include <optional>
#include <vector>

#include "clay/store/editor.h"
#include "io/records/channel_codec.h"
#include "io/records/clay_records.h"
#include "io/records/node_body.h"

namespace argil::io {

/// One reading, after that of the distances. Bytes outside of the band, which no Argil writes, are left out.
class ChannelReading {
 public:
  /// `version` has the distances already, and the channels of `near`, a version that it was made from. `repairing`:
  /// what is lost is unset, else throws Error.
  ChannelReading(ClayRecords& memo, RecordSource& source, const clay::Version& version, const clay::Version& near,
                 uint32_t owner, bool repairing, Job* job)
      : memo_(memo),
        source_(source),
        version_(version),
        near_(near),
        editor_(version),
        owner_(owner),
        repairing_(repairing),
        job_(job) {}

  /// `nearHead`: of `near`, all zero where it has no channels. Adds to read.notes; the new version.
  [[nodiscard]] clay::Version run(const ClayHead& head, const ClayHead& nearHead, ReadClay& read);
  /// Whether all that was read stands there to the bit, so that the head's record can stand for the version.
  [[nodiscard]] bool exact() const { return exact_; }

 private:
  struct State {  // what stands at a block: a record, or 0 or 255 everywhere
    RecordId id = 0;
    bool full = false;
    friend bool operator==(const State&, const State&) = default;
  };
  struct Wanted {
    RecordId id;
    Coord coord;
    uint64_t serial = 0;  // where it was set as it is in the record
  };
  void visit(clay::Channel channel, State now, State near, int level, Coord first);
  [[nodiscard]] std::optional<NodeBody> load(RecordId id, int level, Coord first);
  void loadBricks(clay::Channel channel);
  void fill(clay::Channel channel, const clay::Version& bricksOf, int level, Coord first, bool full);
  /// Sets what lies in the band of `brick`; true when that is all of it.
  bool set(clay::Channel channel, Coord brick, std::span<const uint8_t, clay::kBrickVoxels> values);
  bool teach(clay::Channel channel, RecordId id, const clay::TreePlace& place);
  void lose(const char* what);

  ClayRecords& memo_;
  RecordSource& source_;
  clay::Version version_, near_;
  clay::Editor editor_;
  uint32_t owner_;
  bool repairing_;
  Job* job_;
  std::vector<Wanted> wanted_;            // of the channel in work
  std::map<RecordId, NodeBody> nodes_;    // loaded, of what is read
  std::map<RecordId, uint64_t> serials_;  // of bricks
  uint64_t lost_ = 0;
  bool exact_ = true;
};

}  // namespace argil::io
