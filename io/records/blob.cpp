#include "io/records/blob.h"

#define XXH_INLINE_ALL
#include <xxhash.h>
#include <zstd.h>

#include <algorithm>
#include <cstring>
#include <limits>
#include <memory>
#include <new>
#include <string>

#include "clay/base/error.h"

namespace argil::io {

namespace {

constexpr int kZstdLevel = 3;

constexpr size_t kMostSlice = kMostRecordBody - sizeof(ChunkHead);

[[noreturn]] void damaged(const char* what) {
  throw Error(std::string("damaged: ") + what, Error::Kind::work);
}

struct Chunk {
  ChunkHead head;
  RecordCodec codec;
  std::vector<std::byte> slice;
};

bool readChunk(RecordSource& source, RecordId id, Chunk& chunk) {
  std::vector<std::byte> bytes;
  if (!source.get(id, bytes)) return false;
  const auto record = parseRecord(bytes);
  if (!record || record->header.id != id || record->header.kind != RecordKind::chunk) return false;
  const auto head = chunkHeadOf(record->body);
  if (!head) return false;
  chunk.head = *head;
  chunk.codec = record->header.codec;
  const auto slice = record->body.subspan(sizeof(ChunkHead));
  chunk.slice.assign(slice.begin(), slice.end());
  return true;
}

Chunk firstChunk(RecordSource& source, RecordId id) {
  Chunk chunk;
  if (id == 0 || !readChunk(source, id, chunk)) damaged("the beginning of a stored text, picture or mesh is missing");
  if (chunk.head.index != 0 || chunk.head.count == 0)
    damaged("a stored text, picture or mesh does not begin where it should");
  return chunk;
}

}  // namespace

std::optional<ChunkHead> chunkHeadOf(std::span<const std::byte> body) {
  if (body.size() < sizeof(ChunkHead)) return std::nullopt;
  ChunkHead head;
  std::memcpy(&head, body.data(), sizeof head);
  return head;
}

RecordId putBlob(BlobKind kind, std::span<const std::byte> bytes, RecordIds& ids, RecordSet& held, RecordSink& sink,
                 RecordId as) {
  std::vector<std::byte> packed(ZSTD_compressBound(bytes.size()));
  const size_t size = ZSTD_compress(packed.data(), packed.size(), bytes.data(), bytes.size(), kZstdLevel);
  RecordCodec codec = RecordCodec::raw;
  std::span<const std::byte> stream = bytes;
  if (ZSTD_isError(size) == 0 && size < bytes.size()) {
    codec = RecordCodec::zstd;
    stream = std::span(packed).first(size);
  }
  ChunkHead head{};
  head.blobKind = static_cast<uint8_t>(kind);
  const size_t count = std::max<size_t>(1, (stream.size() + kMostSlice - 1) / kMostSlice);
  if (count > std::numeric_limits<uint32_t>::max())
    throw Error("a mesh or picture is too large for a document", Error::Kind::work);
  head.count = static_cast<uint32_t>(count);
  head.bytes = bytes.size();
  head.checksum = XXH3_64bits(bytes.data(), bytes.size());
  const RecordId first = as != 0 ? as : ids.take(count);
  std::vector<std::byte> body;
  for (head.index = 0; head.index < head.count; ++head.index) {
    const size_t begin = head.index * kMostSlice;
    const auto slice = stream.subspan(begin, std::min(kMostSlice, stream.size() - begin));
    const auto* front = reinterpret_cast<const std::byte*>(&head);
    body.assign(front, front + sizeof head);
    body.insert(body.end(), slice.begin(), slice.end());
    const RecordId id = first + head.index;
    sink.put({RecordKind::chunk, codec, static_cast<uint16_t>(body.size()), 0, id}, body);
    held.add(id);
  }
  return first;
}

std::vector<std::byte> getBlob(BlobKind kind, RecordId id, RecordSource& source, size_t most) {
  Chunk chunk = firstChunk(source, id);
  const ChunkHead head = chunk.head;
  const RecordCodec codec = chunk.codec;
  if (head.blobKind != static_cast<uint8_t>(kind)) damaged("a stored text, picture or mesh is of another kind");
  if (head.bytes > most) throw Error("a stored text, picture or mesh is larger than Argil takes", Error::Kind::work);
  if (codec != RecordCodec::raw && codec != RecordCodec::zstd)
    damaged("a stored text, picture or mesh is packed in an unknown way");
  // Memory grows with what was read, not with what the first chunk announces.
  std::vector<std::byte> bytes;
  ZSTD_DCtx* unpacker = ZSTD_createDCtx();
  if (unpacker == nullptr) throw std::bad_alloc();
  const std::unique_ptr<ZSTD_DCtx, size_t (*)(ZSTD_DCtx*)> guard(unpacker, ZSTD_freeDCtx);
  std::vector<std::byte> window(ZSTD_DStreamOutSize());
  for (uint32_t index = 0;;) {
    if (codec == RecordCodec::raw) {
      bytes.insert(bytes.end(), chunk.slice.begin(), chunk.slice.end());
    } else {
      ZSTD_inBuffer in{chunk.slice.data(), chunk.slice.size(), 0};
      bool full = true;
      while (in.pos < in.size || full) {
        ZSTD_outBuffer out{window.data(), window.size(), 0};
        if (ZSTD_isError(ZSTD_decompressStream(unpacker, &out, &in)) != 0)
          damaged("a stored text, picture or mesh cannot be unpacked");
        bytes.insert(bytes.end(), window.begin(), window.begin() + static_cast<std::ptrdiff_t>(out.pos));
        full = out.pos == out.size;
        if (bytes.size() > head.bytes) break;
      }
    }
    if (bytes.size() > head.bytes) damaged("a stored text, picture or mesh is longer than it says");
    if (++index == head.count) break;
    if (!readChunk(source, id + index, chunk) || chunk.head.index != index || chunk.codec != codec ||
        chunk.head.checksum != head.checksum || chunk.head.count != head.count ||
        chunk.head.blobKind != head.blobKind || chunk.head.bytes != head.bytes || chunk.slice.empty())
      damaged("a piece of a stored text, picture or mesh is missing");
  }
  if (bytes.size() != head.bytes || XXH3_64bits(bytes.data(), bytes.size()) != head.checksum)
    damaged("a stored text, picture or mesh is not what was stored");
  return bytes;
}

void markBlob(RecordSource& source, RecordId id, RecordSet& live) {
  const uint32_t count = firstChunk(source, id).head.count;
  // Only what is there, so that a lying count costs nothing.
  std::vector<RecordId> ids;
  for (uint32_t index = 0; index < count;) {
    ids.clear();
    for (; index < count && ids.size() < 1024; ++index) ids.push_back(id + index);
    size_t found = 0;
    source.getMany(ids, [&](size_t at, std::span<const std::byte>) {
      live.add(ids[at]);
      ++found;
    });
    if (found != ids.size()) damaged("a piece of a stored text, picture or mesh is missing");
  }
}

}  // namespace argil::io
