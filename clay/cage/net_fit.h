#pragma once
// The net whose patches lie nearest to a clay.

#include <memory>

#include "clay/base/work_part.h"
#include "clay/cage/crease_map.h"
#include "clay/cage/patch_net.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

/// What a fit costs: rounds of each stiffness, 1 to 100; places that are fitted along a side of a patch, 6 to 24, of
/// the stiff stages that lead and of the last; and how often at most, 0 to 100, the net is evened out where patches
/// fold.
struct FitEffort {
  int rounds, leading, last, unfoldings;
};

/// Least squares of the patches of a cage to a clay's surface, both ways; two closed meshes, the cage's vertices on the
/// surface. Places of the patches are drawn to the planes of the clay that are nearest to them, vertices of the clay
/// draw what is nearest to them; both are looked for again each round, with a stiffness that falls. Pairs whose sides
/// face opposite ways count nothing, and what lies far off counts more. Creases of the cage are drawn to those of the
/// clay. Where patches fold at the end the net is evened out along the clay; of all nets on that way the one that folds
/// least is taken, if it folds at no more than a tenth of the places of the first. The same for any count of threads.
/// Throws Cancelled. Method: NOTES.md.
[[nodiscard]] PatchSurface fittedNet(const QuadMesh& cage, const TriangleMesh& clay, const NearestTriangle& tree,
                                     const CreaseMap& creases, const FitEffort& effort, int threads,
                                     const WorkPart& part);

}  // namespace argil::clay
