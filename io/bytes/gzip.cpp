#include "io/bytes/gzip.h"

#include <zlib.h>

#include <algorithm>
#include <cstring>
#include <memory>
#include <new>

#include "io/bytes/unpack_limit.h"

namespace argil::io {

namespace {

constexpr size_t kLeast = size_t{64} << 10;
constexpr size_t kStep = size_t{4} << 20;   // unpacked between two looks at the limits
constexpr size_t kFed = size_t{256} << 10;  // packed bytes handed over at once
constexpr int kGzipAlone = 15 + 16;         // the largest window, and a header of gzip

// The last four bytes say how long the last member is, modulo 2^32: a hint, for files of one member.
uint64_t hintOf(const Input& input) {
  uint32_t size = 0;
  if (input.bytes.size() >= 18) std::memcpy(&size, input.bytes.data() + input.bytes.size() - 4, 4);
  return size;
}

void grow(FileBytes& bytes, uint64_t room) {
  auto larger = std::make_unique_for_overwrite<std::byte[]>(room);
  if (bytes.size > 0) std::memcpy(larger.get(), bytes.data.get(), bytes.size);
  bytes.data = std::move(larger);
}

class Inflating {
 public:
  Inflating() {
    if (::inflateInit2(&stream, kGzipAlone) != Z_OK) throw std::bad_alloc();
  }
  ~Inflating() { ::inflateEnd(&stream); }
  Inflating(const Inflating&) = delete;
  Inflating& operator=(const Inflating&) = delete;
  z_stream stream{};
};

[[noreturn]] void failDense(const Input& input) {
  fail(input.name, "unpacks to more than " + std::to_string(kMostUnpackRatio) +
                       " times its size, as no model does; it may be an attack, or unpack it first");
}

}  // namespace

bool isGzip(const Input& input) {
  return input.text().starts_with("\x1f\x8b");
}

FileBytes gunzipped(const Input& input) {
  FileBytes result;
  try {
    Inflating inflating;
    z_stream& stream = inflating.stream;
    const uint64_t hint = isTooDense(hintOf(input), input.bytes.size()) ? 0 : hintOf(input);
    requireMemory(input.name, hint);
    uint64_t room = std::max<uint64_t>(hint + 1, kLeast);  // One to spare: the end comes while there is room.
    grow(result, room);
    for (size_t at = 0;;) {
      if (result.size == room) {
        requireMemory(input.name, result.size + result.size / 2);
        room = std::min(kMostUnpacked, result.size + std::max<uint64_t>(result.size / 2, kLeast));
        grow(result, room);
      }
      const size_t fed = std::min(kFed, input.bytes.size() - at), wanted = std::min(kStep, size_t(room - result.size));
      // zlib's type has no const; it does not write there.
      stream.next_in = reinterpret_cast<Bytef*>(const_cast<std::byte*>(input.bytes.data() + at));
      stream.avail_in = uInt(fed);
      stream.next_out = reinterpret_cast<Bytef*>(result.data.get() + result.size);
      stream.avail_out = uInt(wanted);
      const int outcome = ::inflate(&stream, Z_NO_FLUSH);
      at += fed - stream.avail_in;
      const size_t made = wanted - stream.avail_out;
      result.size += made;
      if (input.job != nullptr) input.job->step(0.1);
      if (outcome == Z_MEM_ERROR) throw std::bad_alloc();
      if (isTooDense(result.size, at)) failDense(input);
      if (result.size >= kMostUnpacked)
        fail(input.name, "unpacks to more than " + std::to_string(kMostUnpacked >> 20) +
                             " MiB; reduce the model or export it in another format");
      if (outcome == Z_STREAM_END) {
        // Another member, the end, or padding of zeros, as tapes leave it.
        const auto rest = input.bytes.subspan(at);
        if (std::all_of(rest.begin(), rest.end(), [](std::byte b) { return b == std::byte{0}; })) break;
        if (::inflateReset(&stream) != Z_OK) throw std::bad_alloc();
      } else if (outcome != Z_OK || (fed == stream.avail_in && made == 0)) {
        fail(input.name, "is damaged or cut off: gzip cannot unpack it; get it again");
      }
    }
  } catch (const std::bad_alloc&) {
    fail(input.name, "does not fit into memory when unpacked; reduce the model first");
  }
  if (result.size == 0) fail(input.name, "holds nothing when unpacked; export it again");
  return result;
}

}  // namespace argil::io
