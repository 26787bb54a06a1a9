#pragma once
// What hangs together among the voxels of one brick, as bits. This module's own.

#include <array>
#include <cstddef>
#include <cstdint>

namespace argil::clay {

/// A bit a voxel: y·8 + z of word x, as Brick::inside.
using BrickMask = std::array<uint64_t, 8>;
inline constexpr BrickMask kFullMask{~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull, ~0ull};
inline constexpr uint64_t kLowestY = 0xffull, kLowestZ = 0x0101010101010101ull;  ///< Of a word.

[[nodiscard]] inline bool holds(const BrickMask& mask, int voxel) {
  return (mask[static_cast<size_t>(voxel >> 6)] >> (voxel & 63)) & 1;
}

/// Takes what hangs together with the first voxel of `left`, across faces, out of it; nothing where it is empty.
[[nodiscard]] inline BrickMask takeComponent(BrickMask& left) {
  BrickMask m{};
  for (size_t x = 0; x < 8; ++x)
    if (left[x] != 0) {
      m[x] = left[x] & (~left[x] + 1);
      break;
    }
  for (bool grown = true; grown;) {
    grown = false;
    for (size_t x = 0; x < 8; ++x) {
      const uint64_t w = m[x];
      uint64_t g = w | (w << 8) | (w >> 8) | ((w << 1) & ~kLowestZ) | ((w >> 1) & ~(kLowestZ << 7));
      if (x > 0) g |= m[x - 1];
      if (x < 7) g |= m[x + 1];
      g &= left[x];
      grown |= g != w;
      m[x] = g;
    }
  }
  for (size_t x = 0; x < 8; ++x) left[x] &= ~m[x];
  return m;
}

/// Whether voxels of a touch voxels of the next brick along an axis.
[[nodiscard]] inline bool touch(const BrickMask& a, const BrickMask& next, int axis) {
  if (axis == 0) return (a[7] & next[0]) != 0;
  for (size_t x = 0; x < 8; ++x)
    if (axis == 1 ? ((a[x] >> 56) & next[x] & kLowestY) != 0 : ((a[x] >> 7) & kLowestZ & next[x]) != 0) return true;
  return false;
}

}  // namespace argil::clay
