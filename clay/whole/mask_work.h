#pragma once
// Masks of a whole piece. Each returns a new version of the same store whose mask alone is another one; the cost
// follows the surface. Any thread. With a job they report progress and throw Cancelled. `threads` (1 to 64) change
// nothing in the result.

#include <optional>
#include <vector>

#include <Eigen/Core>

#include "clay/base/job.h"
#include "clay/store/version.h"

namespace argil::clay {

[[nodiscard]] Version clearMask(const Version& version, Job* job = nullptr);
/// What was free is masked, and the other way round.
[[nodiscard]] Version invertMask(const Version& version, Job* job = nullptr, int threads = 1);
/// Softens its rim by about √(passes / 2) voxels. Throws Error for passes outside 1 to 100.
[[nodiscard]] Version blurMask(const Version& version, int passes, Job* job = nullptr, int threads = 1);

/// A closed curve drawn over a view of the clay.
struct MaskLasso {
  /// Voxel coordinates to the view: (x / w, y / w); what has w ≤ 0 is behind the eye and not meant.
  Eigen::Matrix4d view = Eigen::Matrix4d::Identity();
  /// 3 to 100 000 corners in the view; inside is what it winds around an odd number of times.
  std::vector<Eigen::Vector2d> curve;
  std::optional<Vec3d> eye;  ///< In voxels. Given: only clay that faces it; none: through and through.
  bool erase = false;
};
/// Throws Error for a curve that is none or has numbers that are not finite.
[[nodiscard]] Version maskByLasso(const Version& version, const MaskLasso& lasso, Job* job = nullptr, int threads = 1);

/// Masks what is curved: mean curvature of the surface at a voxel's nearest point, over two voxels.
struct MaskByCavity {
  /// Voxels, 1 to 1000. Hollows as a ball of this radius would leave are masked whole, those of twice the radius not at
  /// all.
  double radius = 8;
  bool ridges = false;  ///< What stands out instead of hollows.
  bool add = false;     ///< To the mask there is; else instead of it.
};
/// Throws Error for a bad radius.
[[nodiscard]] Version maskByCavity(const Version& version, const MaskByCavity& how, Job* job = nullptr,
                                   int threads = 1);

class Sampler;
/// Mean curvature at the point of the surface nearest to a voxel, 1/voxel: above zero where the clay stands out (a ball
/// of radius r: 1/r). Of a voxel in the band.
[[nodiscard]] float meanCurvature(Sampler& clay, Coord voxel);

}  // namespace argil::clay
