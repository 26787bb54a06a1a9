#pragma once
// How far the field of a version is from known distances.

#include <cmath>
#include <functional>

#include "clay/store/sampler.h"
#include "clay/store/version.h"

namespace argil::clay::testing {

struct FieldError {
  double rms = 0, worst = 0;  ///< Voxels.
  Vec3d worstAt = Vec3d::Zero();
  uint64_t voxels = 0;
};

/// Over voxels of `version`'s bricks whose exact distance (voxels, at a voxel coordinate) is below `within`; `counts`
/// may leave places out.
inline FieldError fieldError(const Version& version, const std::function<double(const Vec3d&)>& exact, double within,
                             const std::function<bool(const Vec3d&)>& counts = {}) {
  FieldError error;
  double sum = 0;
  version.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < kBrickVoxels; ++i) {
      const Vec3d p = (brick.coord * 8 + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d();
      const double d = exact(p);
      if (!(std::abs(d) < within) || (counts && !counts(p))) continue;
      const double off = std::abs(double(brick.phi(i)) - d);
      sum += off * off;
      ++error.voxels;
      if (off > error.worst) {
        error.worst = off;
        error.worstAt = p;
      }
    }
  });
  error.rms = std::sqrt(sum / double(std::max<uint64_t>(error.voxels, 1)));
  return error;
}

/// The same between versions: `exact`'s field says what is right.
inline FieldError fieldError(const Version& version, const Version& exact, double within) {
  Sampler sampler(exact);
  return fieldError(
      version,
      [&](const Vec3d& p) {
        return double(sampler.voxel({int(p.x()), int(p.y()), int(p.z())}));
      },
      within);
}

}  // namespace argil::clay::testing
