#pragma once
// Random damage to the bytes of a file.

#include <algorithm>
#include <random>
#include <span>
#include <string>
#include <string_view>

namespace argil::samples {

/// One to four strokes of damage: bytes set, a bit turned, some taken out, some written twice, a word of `interesting`
/// put in, the end cut off or four bytes of ones.
template <class Random>
[[nodiscard]] std::string damaged(std::string bytes, std::span<const std::string_view> interesting, Random& random) {
  const auto below = [&](size_t n) { return std::uniform_int_distribution<size_t>(0, n - 1)(random); };
  for (size_t n = 1 + below(4); n > 0 && !bytes.empty(); --n) {
    const size_t at = below(bytes.size());
    switch (below(7)) {
      case 0:
        bytes[at] = char(below(256));
        break;
      case 1:
        bytes[at] = char(bytes[at] ^ (1 << below(8)));
        break;
      case 2:
        bytes.erase(at, 1 + below(8));
        break;
      case 3:
        bytes.insert(at, interesting[below(interesting.size())]);
        break;
      case 4:
        bytes.insert(at, bytes.substr(below(bytes.size()), below(40)));
        break;
      case 5:
        bytes.resize(at);
        break;
      default:
        bytes.replace(at, std::min<size_t>(bytes.size() - at, 4), "\xff\xff\xff\xff");
    }
  }
  return bytes;
}

}  // namespace argil::samples
