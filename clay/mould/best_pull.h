#pragma once
// The direction in which a shape is taken out of a mould of two halves best.

#include "clay/base/work_part.h"
#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

struct BestPull {
  Vec3d pull = Vec3d::UnitZ();  ///< A unit vector; the opposite is as good.
  double undercutShare = 0;     ///< Of the surface of the finer copy: about.
};

/// Of a thousand directions over half of the sphere and the three axes, by the share of the surface that is an undercut
/// on a coarse copy of the mesh (pullFaces()), and a little by faces without draft and by the height of the mould; the
/// best are looked at again on a finer copy, and around the best of them in smaller and smaller steps. The axes win
/// where nothing is better by a thousandth of that, z before x before y. The same for any `threads`. Throws Error for a
/// mesh without triangles, Cancelled. Cost: some seconds, whatever the mesh.
[[nodiscard]] BestPull bestPull(const TriangleMesh& mesh, double voxelMm, int threads, const WorkPart& part);

}  // namespace argil::clay
