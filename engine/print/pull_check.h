#pragma once
// What stands in the way of taking a piece out of a mould of two halves.

#include <optional>
#include <vector>

#include "clay/base/job.h"
#include "clay/mesh/triangle_mesh.h"

namespace argil::engine {

/// A part of the surface that hangs together and that no half comes off.
struct Undercut {
  Vec3d atMm = Vec3d::Zero();  ///< A place on it, about in its middle.
  double areaMm2 = 0;
};

struct PullReport {
  Vec3d pull = Vec3d::UnitZ();
  double areaMm2 = 0, undercutMm2 = 0;  ///< Of all of the surface, and of the undercuts below with those left out.
  double steepMm2 = 0;                  ///< Has less draft than was asked for.
  std::vector<Undercut> undercuts;      ///< The largest first, without those of less than `uneven` × 10 squared.
};

/// Looks at a surface along a pull (any length but zero), or along the best one. `unevenMm`: what a wall may be uneven
/// by and is no undercut. Throws Error for a mesh without triangles and for draft that is not from 0 to 45 degrees;
/// Cancelled. Cost: clay::pullFaces(), and clay::bestPull() where no pull is given.
[[nodiscard]] PullReport checkPull(const clay::TriangleMesh& mesh, double unevenMm, std::optional<Vec3d> pull,
                                   double draftDegrees, Job* job);

}  // namespace argil::engine
