#pragma once
// A 64-bit hash for equality of content in tests and reports; not for adversaries.

#include <cstdint>
#include <cstring>

namespace argil::clay {

/// Multiply-rotate over 64-bit words. The value depends on the order of what is added.
class Hasher {
 public:
  void add(uint64_t word) {
    state_ = (state_ ^ word) * 0x9e3779b97f4a7c15ull;
    state_ ^= state_ >> 29;
  }
  /// `bytes` need not be a multiple of eight; the tail is padded with zeros.
  void add(const void* data, size_t bytes) {
    const auto* at = static_cast<const unsigned char*>(data);
    for (; bytes >= 8; bytes -= 8, at += 8) {
      uint64_t word;
      std::memcpy(&word, at, 8);
      add(word);
    }
    if (bytes > 0) {
      uint64_t word = 0;
      std::memcpy(&word, at, bytes);
      add(word);
    }
  }
  [[nodiscard]] uint64_t value() const {
    uint64_t x = state_ ^ (state_ >> 32);
    x *= 0xd6e8feb86659fd93ull;
    return x ^ (x >> 32);
  }

 private:
  uint64_t state_ = 0x243f6a8885a308d3ull;
};

}  // namespace argil::clay
