#pragma once
// Records with content of their own, and what a file gives back: for tests of documents and journals.

#include <cstring>
#include <vector>

#include "io/records/record.h"

namespace argil::samples {

/// Of `size` bytes that follow from the seed.
inline std::vector<std::byte> someBytes(size_t size, uint64_t seed) {
  std::vector<std::byte> bytes(size);
  uint64_t state = seed * 0x9e3779b97f4a7c15u + 1;
  for (std::byte& each : bytes) {
    state = state * 6364136223846793005u + 1442695040888963407u;
    each = static_cast<std::byte>(state >> 56);
  }
  return bytes;
}

/// The body that record `id` has in these tests.
inline std::vector<std::byte> bodyOf(io::RecordId id) {
  return someBytes((id * 977) % (io::kMostRecordBody + 1), id);
}

/// A brick or node (by turns) with that body.
inline void putSample(io::RecordSink& sink, io::RecordId id) {
  sink.put({id % 2 == 0 ? io::RecordKind::brick : io::RecordKind::node, io::RecordCodec::raw, 0, 1, id}, bodyOf(id));
}

/// Whether the bytes are that record.
inline bool isSample(std::span<const std::byte> record, io::RecordId id) {
  const auto view = io::parseRecord(record);
  const auto body = bodyOf(id);
  return view && view->header.id == id && std::equal(body.begin(), body.end(), view->body.begin(), view->body.end());
}

/// Which of the ids are there and sound.
inline std::vector<io::RecordId> soundSamples(io::RecordSource& source, const std::vector<io::RecordId>& ids) {
  std::vector<io::RecordId> sound;
  source.getMany(ids, [&](size_t i, std::span<const std::byte> record) {
    if (isSample(record, ids[i])) sound.push_back(ids[i]);
  });
  return sound;
}

inline std::vector<io::RecordId> idsFromTo(io::RecordId first, io::RecordId last) {
  std::vector<io::RecordId> ids;
  for (; first <= last; ++first) ids.push_back(first);
  return ids;
}

}  // namespace argil::samples
