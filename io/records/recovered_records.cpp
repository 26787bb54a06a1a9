#include "io/records/recovered_records.h"

#include <algorithm>
#include <cstring>
#include <tuple>

#include "io/records/blob.h"
#include "io/records/scanned_records.h"

namespace argil::io {

namespace {

template <class Number>
Number numberAt(std::span<const std::byte> bytes, size_t at) {
  Number value;
  std::memcpy(&value, bytes.data() + at, sizeof value);
  return value;
}

struct Chunk {
  ChunkHead head;
  RecordId id;
};

struct Brick {
  uint32_t owner;
  int32_t x, y, z;
  RecordId id;
  [[nodiscard]] auto place() const { return std::tie(owner, x, y, z); }
};

/// The blobs of which every chunk is there, newest first.
std::vector<RecordId> wholeBlobs(std::vector<Chunk>& chunks) {
  std::sort(chunks.begin(), chunks.end(), [](const Chunk& a, const Chunk& b) { return a.id < b.id; });
  chunks.erase(std::unique(chunks.begin(), chunks.end(), [](const Chunk& a, const Chunk& b) { return a.id == b.id; }),
               chunks.end());
  std::vector<RecordId> whole;
  for (size_t first = 0; first < chunks.size(); ++first) {
    const ChunkHead& head = chunks[first].head;
    const RecordId id = chunks[first].id;
    if (head.index != 0 || head.count == 0 || head.count > chunks.size() - first) continue;
    bool all = true;
    for (uint32_t i = 0; i < head.count && all; ++i) {
      const auto& [each, eachId] = chunks[first + i];
      all = eachId == id + i && each.index == i && each.count == head.count && each.bytes == head.bytes &&
            each.checksum == head.checksum;
    }
    if (all) whole.push_back(id);
  }
  std::reverse(whole.begin(), whole.end());
  return whole;
}

}  // namespace

struct RecoveredRecords::State {
  std::vector<Brick> bricks;  ///< By place, newest first.
  std::vector<RecordId> heads, states;
  std::unique_ptr<ScannedRecords> records;
};

RecoveredRecords::RecoveredRecords(const std::filesystem::path& path, Job* job) : state_(std::make_unique<State>()) {
  State& state = *state_;
  std::vector<Chunk> heads, states;
  state.records = std::make_unique<ScannedRecords>(path, job, [&](const RecordView& record, ScannedRecords::Place) {
    const auto body = record.body;
    if (record.header.id == 0) return;
    if (record.header.kind == RecordKind::brick && body.size() >= 12) {
      state.bricks.push_back({record.header.owner, numberAt<int32_t>(body, 0), numberAt<int32_t>(body, 4),
                              numberAt<int32_t>(body, 8), record.header.id});
    } else if (record.header.kind == RecordKind::chunk) {
      const auto head = chunkHeadOf(body);
      if (!head) return;
      if (head->blobKind == uint8_t(BlobKind::head)) heads.push_back({*head, record.header.id});
      if (head->blobKind == uint8_t(BlobKind::state)) states.push_back({*head, record.header.id});
    }
  });
  // The file may hold a record twice, where SQLite has moved it.
  const auto orderBricks = [](const Brick& a, const Brick& b) {
    return a.place() != b.place() ? a.place() < b.place() : a.id > b.id;
  };
  std::sort(state.bricks.begin(), state.bricks.end(), orderBricks);
  const auto same = [](const Brick& a, const Brick& b) { return a.id == b.id && a.place() == b.place(); };
  state.bricks.erase(std::unique(state.bricks.begin(), state.bricks.end(), same), state.bricks.end());
  state.heads = wholeBlobs(heads);
  state.states = wholeBlobs(states);
}

RecoveredRecords::~RecoveredRecords() = default;

const std::vector<RecordId>& RecoveredRecords::heads() const {
  return state_->heads;
}

const std::vector<RecordId>& RecoveredRecords::states() const {
  return state_->states;
}

uint64_t RecoveredRecords::records() const {
  return state_->records->records();
}

RecordId RecoveredRecords::highestId() const {
  return state_->records->highestId();
}

bool RecoveredRecords::get(RecordId id, std::vector<std::byte>& record) {
  return state_->records->get(id, record);
}

void RecoveredRecords::getMany(std::span<const RecordId> ids,
                               const std::function<void(size_t, std::span<const std::byte>)>& each) {
  state_->records->getMany(ids, each);
}

void RecoveredRecords::bricksIn(uint32_t owner, Coord first, int32_t edge,
                                const std::function<void(Coord, RecordId)>& each) const {
  const auto in = [edge](int32_t value, int32_t from) {
    return value >= from && int64_t(value) < int64_t(from) + edge;
  };
  const auto before = [](const Brick& a, const std::tuple<uint32_t, int32_t>& b) { return std::tie(a.owner, a.x) < b; };
  auto at = std::lower_bound(state_->bricks.begin(), state_->bricks.end(), std::tuple(owner, first.x), before);
  for (; at != state_->bricks.end() && at->owner == owner && in(at->x, first.x); ++at) {
    if (in(at->y, first.y) && in(at->z, first.z)) each({at->x, at->y, at->z}, at->id);
  }
}

}  // namespace argil::io
