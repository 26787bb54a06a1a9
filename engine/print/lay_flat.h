#pragma once
// How a piece rests on a bed.

#include <vector>

#include "clay/base/job.h"
#include "clay/store/version.h"
#include "haptics/base/pose.h"

namespace argil::engine {

/// A way to lie that stays as it is.
struct Rest {
  Eigen::Quaterniond turn = Eigen::Quaterniond::Identity();  ///< Of what stood before, in the world.
  double lowMm = 0;                                          ///< z of the bed after that turn about the world's origin.
  double footMm2 = 0;      ///< Area of the polygon around all places that stand on the bed.
  double tipsDegrees = 0;  ///< It falls when the bed is tilted by more, towards where it falls first.
  double heightMm = 0;
};

struct Rests {
  std::vector<Rest> ways;          ///< The largest foot first.
  Vec3d middleMm = Vec3d::Zero();  ///< Of the mass, in the world, as it stood before;
  double lowMm = 0;                ///< and its lowest place.
};

/// All ways in which a solid body stays as it is laid down, as a real one of the same stuff throughout would: rolled
/// from a thousand positions over its edges until the middle of its mass stands above what it touches. Places stand on
/// the bed that are within a quarter of a voxel of it. Hollows count as such. Throws Error for a piece without clay,
/// Cancelled. Cost: about 0.7 s for a million triangles on two threads.
[[nodiscard]] Rests restsOf(const clay::Version& version, const haptics::Pose& pose, Job* job);

}  // namespace argil::engine
