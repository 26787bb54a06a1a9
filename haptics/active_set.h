#pragma once
// The place nearest to the hand that no plane forbids.

#include <array>
#include <cstdint>

#include "clay/vec.h"
#include "haptics/realtime.h"

namespace argil::haptics {

/// The half-space normal · x >= offset; the normal is of unit length.
struct HalfSpace {
  Vec3d normal = Vec3d::UnitZ();
  double offset = 0;
};

inline constexpr int kMaxHalfSpaces = 8;

struct ActiveSet {
  Vec3d x = Vec3d::Zero();            ///< The nearest allowed point.
  std::array<int, 3> active{};        ///< Indices of the planes that hold it there.
  std::array<double, 3> multiplier{}; ///< Of each, >= 0: x - goal = sum of multiplier · normal.
  int count = 0;                      ///< 0 to 3.
  bool feasible = true;               ///< False: the planes leave no place; x is the goal.
};

/// Minimises |x - goal|² under every half-space by trying each set of at most three active planes (Ruspini, §4): exact, no
/// iteration. At most kMaxHalfSpaces planes are looked at. Cost: 0.05 µs for two planes, about 2 µs for eight.
[[nodiscard]] ActiveSet nearestAllowed(const Vec3d& goal, const HalfSpace* planes, int count) ARGIL_REALTIME;

}  // namespace argil::haptics
