#pragma once
// Something for a piece to stand on.

#include "clay/base/job.h"
#include "clay/store/version.h"
#include "haptics/base/pose.h"

namespace argil::clay {
struct ThinParts;  // clay/field/thin_parts.h
}

namespace argil::engine {

struct BaseOptions {
  bool square = false;  ///< As wide and deep as the piece and the margin; else round, around all of it.
  double heightMm = 5;  ///< At least 4 voxels.
  double marginMm = 3;  ///< Beyond the piece, all around, 0 and more.
  double sunkMm = 1;    ///< How deep the piece stands in it: less than the height.
  int dots = 0;         ///< 0 to 9, bored into its underside, to tell pieces apart where no text can be read.
};

/// The piece, as it stands in the world, joined to a plate below it. In the piece's store. Throws Error for what is out
/// of range and a piece without clay, Cancelled. What goes because it is too thin is added to `gone`. Cost: that of
/// joining, and of the plate.
[[nodiscard]] clay::Version withBase(const clay::Version& version, const haptics::Pose& pose,
                                     const BaseOptions& options, Job* job, clay::ThinParts* gone = nullptr);

}  // namespace argil::engine
