#pragma once
// The unit in which documents and journals keep everything: small, checked, readable by itself.

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <vector>

namespace argil::io {

/// Names a record for the life of a document and its journals; 0 is none. Numbers are given in rising order and never
/// used twice.
using RecordId = uint64_t;

/// Stored in files: numbers are never given a new meaning.
enum class RecordKind : uint8_t {
  brick = 1,  ///< One clay brick: coordinate and 512 distances (clay_records.h).
  /// One node of a version's tree: which of its 512 places are inside, outside, or a record (clay_records.h).
  node = 2,
  chunk = 3,         ///< A piece of a blob: a mesh, a picture, a text (blob.h).
  channelBrick = 4,  ///< One channel of one brick: coordinate and 512 bytes (channel_codec.h).
  clay = 5,          ///< A version with channels: the roots of its trees (channel_codec.h).
  // Journals alone, without an id; the body is text in JSON but for strokePoints and strokeSamples
  // (engine/saving/journal.h).
  journalBegin = 16,
  step = 17,
  went = 18,
  strokeBegin = 19,
  strokePoints = 20,
  strokeLift = 21,
  strokeEnd = 22,
  state = 23,
  saving = 24,
  strokeSamples = 25,  ///< Points with pressure and rotation.
  replaying = 26,      ///< A recovery is about to repeat a stroke, or has repeated them all.
};

inline constexpr RecordKind kLastStoredKind = RecordKind::clay;  ///< Of those with an id.

/// How the body is packed. Stored in files: numbers are never given a new meaning.
enum class RecordCodec : uint8_t {
  raw = 0,
  zstd = 1,
  predicted = 2,  ///< Bricks alone (brick_codec.h).
  raw16 = 3,      ///< The same of bricks of 16-bit distances.
  predicted16 = 4,
};

/// The first document schema that knows records of a kind and codec.
inline constexpr int schemaOf(RecordKind kind, RecordCodec codec) {
  if (codec >= RecordCodec::raw16) return 3;
  return kind == RecordKind::channelBrick || kind == RecordKind::clay ? 2 : 1;
}

inline constexpr size_t kRecordHeaderBytes = 40;
/// Header and body: a record lies whole in one page of a document.
inline constexpr size_t kMostRecordBytes = 8000;
inline constexpr size_t kMostRecordBody = kMostRecordBytes - kRecordHeaderBytes;

/// As it stands in front of each body, little endian: magic (8 bytes), kind, codec, body length (2 bytes), owner (4),
/// id (8), reserved (8, zero), XXH3-64 of the 32 bytes before and the body (8).
struct RecordHeader {
  RecordKind kind{};
  RecordCodec codec = RecordCodec::raw;
  uint16_t bodyBytes = 0;
  uint32_t owner = 0;  ///< Of bricks and nodes: which clay of the document; else 0.
  RecordId id = 0;     ///< 0: nothing refers to it.
};

/// Header and body. Points into the bytes that it was read from.
struct RecordView {
  RecordHeader header;
  std::span<const std::byte> body;
  std::span<const std::byte> whole;
};

/// Appends a record. The body is at most kMostRecordBody bytes long.
void appendRecord(std::vector<std::byte>& to, const RecordHeader& header, std::span<const std::byte> body);

/// The record that begins at the first byte; nothing when there is none, it is cut off or its checksum differs. Any
/// bytes are allowed.
[[nodiscard]] std::optional<RecordView> parseRecord(std::span<const std::byte> bytes);

/// Where the next whole and sound record begins at or behind `from`; bytes.size() when there is none. Any bytes are
/// allowed. Cost O(bytes).
[[nodiscard]] size_t findRecord(std::span<const std::byte> bytes, size_t from);

/// Takes records, whole ones of one kind and id each. What put() throws leaves nothing half-written where the file can
/// promise it.
class RecordSink {
 public:
  virtual ~RecordSink() = default;
  virtual void put(const RecordHeader& header, std::span<const std::byte> body) = 0;
};

/// Finds records by id.
class RecordSource {
 public:
  virtual ~RecordSource() = default;
  /// The record, copied into `record`: header and body as parseRecord takes them. False when it is not there. What is
  /// there may be damaged. One thread.
  virtual bool get(RecordId id, std::vector<std::byte>& record) = 0;
  /// Calls back with each of `ids` (rising) that is there, in that order: (index in ids, the record). Faster than one
  /// by one.
  virtual void getMany(std::span<const RecordId> ids,
                       const std::function<void(size_t, std::span<const std::byte>)>& each) = 0;
};

/// Which ids a file holds: 128 bytes of memory for one that stands alone, a bit where many stand together. A file may
/// number its few records as high as it likes. One thread.
class RecordSet {
 public:
  void add(RecordId id) { pages_[id / kPage][id % kPage / 64] |= bitOf(id); }
  void remove(RecordId id) {
    if (const auto at = pages_.find(id / kPage); at != pages_.end()) at->second[id % kPage / 64] &= ~bitOf(id);
  }
  /// Only what the other one has too stays.
  void intersect(const RecordSet& other) {
    for (auto& [place, page] : pages_) {
      const Page& beside = other.pageAt(place);
      for (size_t i = 0; i < page.size(); ++i) page[i] &= beside[i];
    }
  }
  /// Ids that the other one has not, rising.
  [[nodiscard]] std::vector<RecordId> without(const RecordSet& other) const {
    std::vector<RecordId> ids;
    for (const auto& [place, page] : pages_) {
      const Page& beside = other.pageAt(place);
      for (size_t i = 0; i < page.size(); ++i) {
        for (uint64_t word = page[i] & ~beside[i]; word != 0; word &= word - 1)
          ids.push_back(place * kPage + 64 * i + static_cast<unsigned>(std::countr_zero(word)));
      }
    }
    return ids;
  }
  [[nodiscard]] bool contains(RecordId id) const { return (pageAt(id / kPage)[id % kPage / 64] & bitOf(id)) != 0; }

 private:
  static constexpr uint64_t kPage = 512;  // ids
  using Page = std::array<uint64_t, kPage / 64>;

  static uint64_t bitOf(RecordId id) { return uint64_t{1} << (id % 64); }
  [[nodiscard]] const Page& pageAt(uint64_t place) const {
    static constexpr Page kEmpty = {};
    const auto at = pages_.find(place);
    return at == pages_.end() ? kEmpty : at->second;
  }

  std::map<uint64_t, Page> pages_;  // A tree, as no choice of ids makes it slow.
};

}  // namespace argil::io
