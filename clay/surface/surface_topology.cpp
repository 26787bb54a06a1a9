#include "clay/surface/surface_topology.h"

namespace argil::clay {

TopologyReport surfaceTopology(const Surface& surface, const std::function<Vec3d(const Vec3d&)>& place) {
  Vec3d low = Vec3d::Zero(), high = Vec3d::Zero();
  bool any = false;
  surface.forEachSlab(SlabOf::vertices, [&](const SurfaceSlab& slab) {
    for (const Vec3d& each : slab.positions) {
      const Vec3d p = place ? place(each) : each;
      low = any ? low.cwiseMin(p).eval() : p;
      high = any ? high.cwiseMax(p).eval() : p;
      any = true;
    }
  });
  TopologyCheck check(low + (high - low) / 2);
  std::vector<Vec3d> placed;
  surface.forEachSlab(SlabOf::both, [&](const SurfaceSlab& slab) {
    // A slab's triangles name vertices of its own and of the slab before.
    placed = slab.positions;
    if (place)
      for (Vec3d& p : placed) p = place(p);
    check.add(placed, slab.triangles);
    check.settle(slab.firstVertex);
  });
  return check.finish();
}

}  // namespace argil::clay
