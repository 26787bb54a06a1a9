#pragma once
// Pieces that a printer would make one body of: they overlap, touch, or are nearer than its narrowest gap.

#include <optional>
#include <span>
#include <vector>

#include "clay/base/job.h"
#include "clay/store/version.h"
#include "haptics/base/pose.h"

namespace argil::engine {

struct PlacedClay {
  clay::Version version;
  haptics::Pose pose;
};

struct PiecesMeet {
  size_t first = 0, second = 0;  ///< Of the pieces given, first < second.
  bool overlap = false;          ///< The one reaches into the other; else they are apart.
  double mm = 0;                 ///< By so much, at most; or the least gap, 0 where they touch.
  Vec3d atMm = Vec3d::Zero();    ///< There, in the world.
};

/// All pairs that overlap or are apart by less than `gapMm`, in order; with `only`, those that it is one of. Vertices
/// of either are measured in the field of the other: what is told is off by a fifth of a voxel where faces are smooth,
/// and by half of one at creases. Less than a tenth of a voxel is no overlap but a touch; where the surfaces are one
/// over a common clay, what is told is a voxel. Pieces without clay meet nothing. Cost: boxes of bricks for pieces that
/// are far from each other; for others their surfaces, and a look into the field for each vertex near the other piece.
/// `job` may be null. Throws Cancelled.
[[nodiscard]] std::vector<PiecesMeet> piecesThatMeet(std::span<const PlacedClay> pieces, double gapMm, Job* job,
                                                     std::optional<size_t> only = {});

}  // namespace argil::engine
