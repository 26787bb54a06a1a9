#pragma once
// The place nearest to the hand that no plane forbids.

#include <array>
#include <cstdint>

#include "clay/base/vec.h"
#include "haptics/base/realtime.h"
#include "haptics/base/subspace.h"

namespace argil::haptics {

/// The half-space normal · x >= offset; the normal is of unit length.
struct HalfSpace {
  Vec3d normal = Vec3d::UnitZ();
  double offset = 0;
};

inline constexpr int kMaxHalfSpaces = 8;

struct ActiveSet {
  Vec3d x = Vec3d::Zero();             ///< The nearest allowed point.
  std::array<int, 3> active{};         ///< Indices of the planes that hold it there.
  std::array<double, 3> multiplier{};  ///< Of each, >= 0: x - goal = sum of multiplier · normal.
  int count = 0;                       ///< 0 to 3.
  bool feasible = true;                ///< False: the planes leave no place; x is the goal.
};

/// Minimises |x - goal|² under every half-space by trying each set of at most three active planes (Ruspini et al.
/// 1997): exact, no iteration. At most kMaxHalfSpaces planes are looked at. Cost: 0.05 µs for two planes, about 2 µs
/// for eight.
[[nodiscard]] ActiveSet nearestAllowed(const Vec3d& goal, const HalfSpace* planes, int count) ARGIL_REALTIME;

/// The same among the places of `within`: locks are equalities. x - (nearest place of `within` to the goal) is then the
/// sum of multiplier · the part of the normal along `within`; what is left of x - goal, the lock pays. Where not all
/// planes can hold, the first `hard` of them come first (keep-outs before clay): x, active and multiplier are theirs
/// alone, or the projected goal when these contradict `within` too, and feasible is false. Cost: that of the free case
/// and some 0.03 µs.
[[nodiscard]] ActiveSet nearestAllowed(const Vec3d& goal, const HalfSpace* planes, int count, const Subspace& within,
                                       int hard = 0) ARGIL_REALTIME;

}  // namespace argil::haptics
