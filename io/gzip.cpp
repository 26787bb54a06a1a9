#include "io/gzip.h"

#include <libdeflate.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>

#include "io/zip_reader.h"

namespace argil::io {

namespace {

constexpr size_t kLeast = size_t(64) << 10;

// What may come out of so many packed bytes.
uint64_t mostFrom(uint64_t packed) {
  return std::min(ZipReader::kMostBytes, std::max(ZipReader::kFreeBytes, packed * ZipReader::kMostRatio));
}

// The last four bytes say how long the last member is, modulo 2^32: a hint, for files of one member.
uint64_t hintOf(const Input& input) {
  uint32_t size = 0;
  if (input.bytes.size() >= 18) std::memcpy(&size, input.bytes.data() + input.bytes.size() - 4, 4);
  return size;
}

void grow(FileBytes& bytes, uint64_t room, size_t used) {
  auto larger = std::make_unique_for_overwrite<std::byte[]>(room);
  if (used > 0) std::memcpy(larger.get(), bytes.data.get(), used);
  bytes.data = std::move(larger);
}

}  // namespace

bool isGzip(const Input& input) {
  return input.text().starts_with("\x1f\x8b");
}

FileBytes gunzipped(const Input& input) {
  const std::unique_ptr<libdeflate_decompressor, void (*)(libdeflate_decompressor*)> unpacker(
      libdeflate_alloc_decompressor(), libdeflate_free_decompressor);
  if (unpacker == nullptr) throw std::bad_alloc();
  const uint64_t most = mostFrom(input.bytes.size());
  FileBytes result;
  try {
    uint64_t room = std::clamp<uint64_t>(hintOf(input), kLeast, most);
    grow(result, room, 0);
    for (size_t at = 0; at < input.bytes.size();) {
      if (input.job != nullptr) input.job->step(0.1);
      size_t used = 0, made = 0;
      const auto outcome =
          libdeflate_gzip_decompress_ex(unpacker.get(), input.bytes.data() + at, input.bytes.size() - at,
                                        result.data.get() + result.size, room - result.size, &used, &made);
      if (outcome == LIBDEFLATE_INSUFFICIENT_SPACE) {
        if (room == most)
          fail(input.name, "unpacks to more than " + std::to_string(most >> 20) +
                               " MiB; reduce the model or export it in another format");
        room = std::min(most, 2 * room);
        grow(result, room, result.size);
        continue;
      }
      // Padding of zeros behind the last member, as tapes leave it.
      const auto rest = input.bytes.subspan(at);
      if (outcome != LIBDEFLATE_SUCCESS && at > 0 &&
          std::all_of(rest.begin(), rest.end(), [](std::byte b) { return b == std::byte{0}; }))
        break;
      if (outcome != LIBDEFLATE_SUCCESS) fail(input.name, "is damaged or cut off: gzip cannot unpack it; get it again");
      at += used;
      result.size += made;
    }
  } catch (const std::bad_alloc&) {
    fail(input.name, "does not fit into memory when unpacked; reduce the model first");
  }
  if (result.size == 0) fail(input.name, "holds nothing when unpacked; export it again");
  return result;
}

}  // namespace argil::io
