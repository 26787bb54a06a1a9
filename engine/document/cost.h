#pragma once
// What clay will cost before it is made.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "clay/kernels/brick.h"
#include "engine/document/machine_speed.h"
#include "engine/document/quality.h"

namespace argil::engine {

/// Of clay with so much surface. Within a quarter for what `argil bench costs` tries; shapes whose walls are thinner
/// than the band take less.
struct ClayCost {
  double activeVoxels = 0;  ///< Nearer to the surface than the band.
  double bytes = 0;         ///< Clay and the surface that shows it.
  double triangles = 0;
  double dabMs = 0;   ///< A carving dab of `tipMm`, from the hand to its triangles, one thread.
  double edgeMm = 0;  ///< How far the rim of a cut lies off, RMS.
};

struct ClayPlan {
  double areaMm2 = 0, voxelMm = 0.5, band = 3;
  /// Mean over the area of |x| + |y| + |z| of the normal: 1 where all lies along the axes, 1.5 for what faces
  /// everywhere.
  double slant = 1.5;
  clay::Precision precision = clay::Precision::float32;
  double tipMm = 5;
};
[[nodiscard]] ClayCost costOf(const ClayPlan& plan, const MachineSpeed& machine);

/// What this machine can do: balanced, with as many voxels across as keep a dab of a sixteenth of the side within
/// kMostDabMs and clay of a ball with its surface within a sixteenth of `memoryBytes`, as undo, files and pictures want
/// theirs.
[[nodiscard]] Quality machineQuality(const MachineSpeed& machine, std::optional<uint64_t> memoryBytes);
inline constexpr double kMostDabMs = 8;

/// As readQuality(text), which takes a preset's name: and "machine" too, of this one (measured, see machineSpeed()).
[[nodiscard]] Quality readQualityHere(std::string_view text);

/// "0.25 mm: 8.1 M voxels, 290 MB, a dab of 5 mm 1.2 ms, rims of cuts within 0.044 mm, 4.1 M triangles".
[[nodiscard]] std::string sentence(const ClayPlan& plan, const ClayCost& cost);

}  // namespace argil::engine
