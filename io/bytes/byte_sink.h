#pragma once
// Where encoders put their bytes: buffers in front of an atomic file.

#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <memory>
#include <string_view>
#include <vector>

#include "io/bytes/atomic_file.h"

namespace argil::io {

/// Collects bytes and hands them to the file in large pieces: while one is written, by a thread of the sink's own that
/// starts with the second, the next is filled. Single numbers are little endian. Memory: two pieces. One thread; the
/// file is the sink's from the first byte to flush(). Every member may throw what AtomicFile::write throws, also for
/// bytes that were given before.
class ByteSink {
 public:
  static constexpr size_t kSize = size_t(512) << 10;  ///< Bytes of a piece: fits the second cache.

  explicit ByteSink(AtomicFile& file);
  ~ByteSink();
  ByteSink(const ByteSink&) = delete;
  ByteSink& operator=(const ByteSink&) = delete;

  void text(std::string_view text) { put(text.data(), text.size()); }
  /// The shortest decimal form that reads back to the same bits.
  template <class Number>
  void decimal(Number value) {
    char digits[32];
    const auto result = std::to_chars(digits, digits + sizeof digits, value);
    put(digits, size_t(result.ptr - digits));
  }
  template <class Number>
  void little(Number value) {
    static_assert(std::endian::native == std::endian::little, "swap the bytes here for a big-endian machine");
    put(&value, sizeof value);
  }
  /// The next `size` bytes, at most kSize, for the caller to fill before the next call.
  std::byte* room(size_t size) {
    if (used_ + size > kSize) handOver();
    used_ += size;
    return buffer_.data() + used_ - size;
  }
  /// All bytes are with the file when it returns.
  void flush();

 private:
  class Writer;

  void handOver();
  void put(const void* bytes, size_t size) {
    if (size > kSize) {
      putLarge(bytes, size);
      return;
    }
    std::memcpy(room(size), bytes, size);
  }
  void putLarge(const void* bytes, size_t size);

  AtomicFile& file_;
  std::vector<std::byte> buffer_;
  size_t used_ = 0;
  std::unique_ptr<Writer> writer_;
};

}  // namespace argil::io
