#pragma once
// Numbers for repeatable scenes.

#include <cstdint>

#include "clay/base/vec.h"

namespace argil::engine {

/// SplitMix64 (G. Steele et al., "Fast splittable pseudorandom number generators", 2014): equal seeds give equal
/// numbers on every machine, which the standard library's distributions do not promise.
class Random {
 public:
  explicit Random(uint64_t seed) : state_(seed) {}

  uint64_t next() {
    uint64_t z = state_ += 0x9e3779b97f4a7c15u;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }
  /// In [0, count); count ≥ 1.
  size_t below(size_t count) { return next() % count; }
  /// In [0, 1).
  double unit() { return double(next() >> 11) * 0x1p-53; }
  double between(double low, double high) { return low + (high - low) * unit(); }
  /// Evenly in the ball of radius 1.
  Vec3d inBall() {
    for (;;) {
      const double x = between(-1, 1), y = between(-1, 1), z = between(-1, 1);
      if (x * x + y * y + z * z <= 1) return {x, y, z};
    }
  }

 private:
  uint64_t state_;
};

}  // namespace argil::engine
