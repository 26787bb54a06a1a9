#pragma once
// How a stroke is repeated: in mirrors and around an axis.

#include <vector>

#include "clay/brush/brush.h"
#include "clay/kernels/grid.h"
#include "haptics/base/pose.h"

namespace argil::engine {

/// A mirror plane, world mm; the normal's length does not matter.
struct MirrorPlane {
  Vec3d pointMm = Vec3d::Zero(), normal = Vec3d::UnitX();
  friend bool operator==(const MirrorPlane&, const MirrorPlane&) = default;
};

inline constexpr size_t kMostMirrors = 3;
inline constexpr int kMostTurns = 8;  ///< 64 images in all.

/// Once for each plane, again for their products, and all of that in each of `turns` places around the axis.
struct StrokeImages {
  std::vector<MirrorPlane> mirrors;                          ///< kMostMirrors at most.
  int turns = 1;                                             ///< 1 to kMostTurns.
  Vec3d axisPointMm = Vec3d::Zero(), axis = Vec3d::UnitZ();  ///< World mm; the length does not matter.
  friend bool operator==(const StrokeImages&, const StrokeImages&) = default;
};

/// Where each image of a stamp lies, in voxels. The first is the stamp itself; image i and image i ^ 2^k are mirror
/// images in plane k.
class ImageMaps {
 public:
  ImageMaps() = default;
  ImageMaps(const StrokeImages& images, const clay::Grid& grid, const haptics::Pose& pose);
  [[nodiscard]] size_t count() const { return maps_.size(); }
  /// A place of an image becomes what it is to image 0.
  void bringBack(clay::WallAhead& wall) const;
  /// Replaces `out` by all images of a stamp.
  void apply(const clay::Stamp& stamp, std::vector<clay::Stamp>& out) const;

 private:
  struct Map {
    Eigen::Matrix3d turn = Eigen::Matrix3d::Identity();
    Vec3d shift = Vec3d::Zero();
  };
  std::vector<Map> maps_{Map{}};
};

}  // namespace argil::engine
