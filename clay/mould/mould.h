#pragma once
// A mould of two halves around a clay.

#include <optional>
#include <vector>

#include "clay/base/work_part.h"
#include "clay/store/version.h"

namespace argil::clay {

struct MouldOptions {
  std::optional<Vec3d> pull = {};  ///< mm of the piece, any length but zero; none: bestPull().
  double wallMm = 8;               ///< Of the block around the clay, on each side: at least 4 voxels.
  bool keys = true;                ///< Cones in the corners that hold the halves in place.
  double clearanceMm = 0.15;       ///< Between a key and its hole, 0 to 5.
  double sprueMm = 6;              ///< Width of the way in at the clay; 0: none.
  bool vents = true;               ///< Ways out for air wherever it would be caught,
  double ventMm = 1.5;             ///< so wide: at least 3 voxels.
};

struct Mould {
  /// In the frame of `turn`, stores of their own: what is taken off along +z, and what along −z.
  Version upper, lower;
  Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();  ///< From the piece to where the pull is +z.
  double clayMm3 = 0;                                  ///< Of the piece.
  double undercutMm3 = 0;                              ///< That the cast has and the clay has not.
  double steepestDegrees = 0;                          ///< Of the surface between the halves.
  int keys = 0, sprues = 0, vents = 0;
};

/// A block less the clay, divided so that both halves come off whatever the clay is: of a point that has clay neither
/// above nor below it the surface between (partingHeights()) decides; what has clay below it alone is the upper half's,
/// what has clay above it alone the lower's, and what has clay on both sides is undercut, cavity or clay, and belongs
/// to neither. So the cast is the clay with what a pull cannot leave free filled in. Sprues stand where the clay is
/// highest, vents on its other peaks of a millimetre and two voxels or more. Throws Error for what is out of range and
/// clay without a surface; Cancelled. The same for any `threads` (0: all cores). Cost: that of the block's columns, and
/// of its surfaces; turned, a resampling.
[[nodiscard]] Mould makeMould(const Version& version, const MouldOptions& options, int threads, const WorkPart& part);

}  // namespace argil::clay
