#pragma once
// The buzz of a volume that jumps within a voxel or two, in closed loop: which contact makes it and which does not.

#include <string_view>
#include <vector>

#include "clay/base/vec.h"
#include "haptics/base/device.h"

namespace argil::haptics {

struct BuzzTick {
  double timeS = 0;
  Vec3d hand = Vec3d::Zero();   ///< True place of the tool, mm.
  Vec3d force = Vec3d::Zero();  ///< Commanded, N.
  bool touching = false;
};

struct BuzzRun {
  std::vector<BuzzTick> ticks;  ///< 1 kHz.
  double jumpRms = 0;  ///< Change of force from tick to tick while pressing and gliding, RMS, % of the device's peak.
  double swingMm = 0;  ///< Of the tool across the wall within 50 ms, RMS over the same time.
  /// How often a second the tool turns round by more than 0.05 mm: twice the frequency of a buzz.
  double reversals = 0;
  int popped = 0;  ///< Ticks on the far side of the wall.
};

/// A wall of four voxels whose field is full inside and full outside, as a threshold cuts it out of a scan. A simulated
/// hand with the simulated device of `sheet` (one tick of delay) reaches for a place 3 mm below its top, holds for half
/// a second and glides along for a second at 40 mm/s. Contact alone, at 1 kHz: no safety and no passivity control hide
/// what the method does. `contact`: one of contactNames(). Deterministic.
[[nodiscard]] BuzzRun runBuzz(std::string_view contact, const DeviceSheet& sheet);
inline constexpr double kBuzzVoxelMm = 0.5, kBuzzBallMm = 1, kBuzzStiffnessNmm = 2, kBuzzPressS = 0.5, kBuzzGlideS = 1;

}  // namespace argil::haptics
