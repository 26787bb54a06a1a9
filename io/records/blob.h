#pragma once
// Bytes of any length as chunk records.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "io/records/clay_records.h"
#include "io/records/record.h"

namespace argil::io {

/// What a blob is, so that a damaged file can be recovered. Stored in files: numbers are never given a new meaning.
enum class BlobKind : uint8_t {
  head = 1,     ///< What a saved document consists of, JSON: the newest one counts.
  state = 2,    ///< A document at one moment, JSON (engine/text/document_text.h).
  mesh = 3,     ///< A part's mesh.
  picture = 4,  ///< PNG.
};

/// Stands in front of each chunk of a blob, little endian.
struct ChunkHead {
  uint8_t blobKind;  ///< A BlobKind.
  uint8_t reserved[3];
  uint32_t index, count;  ///< Which chunk of how many.
  uint32_t reserved2;
  uint64_t bytes;     ///< Of the whole blob, unpacked.
  uint64_t checksum;  ///< XXH3-64 of these.
};
static_assert(sizeof(ChunkHead) == 32);

/// The head of a chunk record's body; nothing when the body is too short. Any bytes are allowed.
[[nodiscard]] std::optional<ChunkHead> chunkHeadOf(std::span<const std::byte> body);

/// Writes a blob as chunks of consecutive ids (kind, index, count of chunks, length in all and a checksum of the whole
/// stand in each); packed with zstd. The id of the first names it. `as`, not 0: the id that the same bytes got before,
/// in another file.
RecordId putBlob(BlobKind kind, std::span<const std::byte> bytes, RecordIds& ids, RecordSet& held, RecordSink& sink,
                 RecordId as = 0);

/// The bytes of a blob, at most `most` of them. Throws Error (kind work) when a chunk is missing or damaged, it is of
/// another kind, or longer.
[[nodiscard]] std::vector<std::byte> getBlob(BlobKind kind, RecordId id, RecordSource& source, size_t most);

/// The ids of its chunks, added to `live`. Throws Error (kind work) when one is missing.
void markBlob(RecordSource& source, RecordId id, RecordSet& live);

}  // namespace argil::io
