#pragma once
// How wide a way is at its narrowest place, between voxels. This module's own.

#include <array>
#include <cstddef>
#include <cstdint>

#include "clay/store/version.h"

namespace argil::clay {

/// A box of voxels around the narrowest one of a way.
struct NeckBox {
  static constexpr int kReach = 3, kEdge = 2 * kReach + 1;
  /// Which end of the way a voxel belongs to.
  enum class End : uint8_t { none, one, other };

  Coord middle;
  std::array<float, kEdge * kEdge * kEdge> distance;  ///< To the clay, voxels; infinite where it is not known.
  std::array<End, kEdge * kEdge * kEdge> end;
  /// Of a voxel by its step from the middle.
  [[nodiscard]] static constexpr size_t number(Coord step) {
    return static_cast<size_t>(((step.x + kReach) * kEdge + step.y + kReach) * kEdge + step.z + kReach);
  }
};

struct NeckWidth {
  Vec3d at;       ///< Voxels.
  double radius;  ///< Of the largest ball that passes, voxels.
};

/// The narrowest place of the widest way between the two ends. That of the middle voxel, where one of them does not
/// reach the rim of the box. Cost: some 10 ms, more for wide ways.
[[nodiscard]] NeckWidth neckWidth(const Version& version, const NeckBox& box);

}  // namespace argil::clay
