#pragma once
// Where encoders put their bytes: a buffer in front of an atomic file.

#include <bit>
#include <charconv>
#include <cstdint>
#include <cstring>
#include <string_view>
#include <vector>

#include "io/atomic_file.h"

namespace argil::io {

/// Collects bytes and hands them to the file in large pieces. Single numbers are little endian.
class ByteSink {
 public:
  explicit ByteSink(AtomicFile& file) : file_(file), buffer_(kSize) {}

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
  void flush() {
    file_.write({buffer_.data(), used_});
    used_ = 0;
  }

 private:
  static constexpr size_t kSize = size_t(256) << 10;

  void put(const void* bytes, size_t size) {
    if (used_ + size > kSize) flush();
    if (size > kSize) {
      file_.write({static_cast<const std::byte*>(bytes), size});
      return;
    }
    std::memcpy(buffer_.data() + used_, bytes, size);
    used_ += size;
  }

  AtomicFile& file_;
  std::vector<std::byte> buffer_;
  size_t used_ = 0;
};

}  // namespace argil::io
