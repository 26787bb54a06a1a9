// Where a ray meets the surface: the beam's end, picking.

#include <tuple>

#include "clay/surface/rim_vertices.h"
#include "render/surface/chunk_works.h"

namespace argil::render {

std::optional<RayHit> SurfaceLayout::raycast(const Ray& rayMm) const {
  // The direction keeps its length, so distances stay mm.
  const double scale = 1 / grid_.voxelMm;
  Ray ray{grid_.toVoxel(rayMm.origin), rayMm.direction * scale, rayMm.first, rayMm.last};
  RayHit hit;
  bool any = false;
  for (const ChunkDraw& draw : draws_) {
    if (enterBox(ray, draw.min, draw.max) == kNever) continue;
    const Chunk& chunk = chunks_.at(draw.chunk);
    const Lower lower = lowerOf(chunk);
    forEachPlace(chunk.drawn, [&](size_t place) {
      const Coord coord = brickAt(chunk, place);
      const Vec3d base = (coord * clay::kBrickEdge).toVec3d();
      // A quad reaches one cell into the bricks below its own, a vertex on a crease out of its cell.
      if (enterBox(ray, base - Vec3d::Constant(1 + clay::kVertexReach),
                   base + Vec3d::Constant(clay::kBrickEdge + clay::kVertexReach)) == kNever)
        return;
      const Bases bases = basesOf(lower, place);
      const auto corner = [&](clay::VertexRef ref) -> Vec3d {
        const int n = ref >> clay::kVertexRefBits;
        const Coord owner = coord - Coord{n & 1, (n >> 1) & 1, n >> 2};
        return (owner * clay::kBrickEdge).toVec3d() +
               bases[size_t(n)].brick->mesh->positions[ref & clay::kVertexRefIndex].cast<double>();
      };
      for (const auto& quad : bases[0].brick->mesh->quads) {
        if (unseen(bases, quad)) continue;
        const Vec3d a = corner(quad[0]), b = corner(quad[1]), c = corner(quad[2]), d = corner(quad[3]);
        for (const auto& [p, q, r] : {std::tie(a, b, c), std::tie(a, c, d)}) {
          const double t = hitTriangle(ray, p, q, r);
          if (t == kNever || (any && t >= hit.distanceMm)) continue;
          any = true;
          ray.last = t;
          hit.distanceMm = t;
          hit.normal = (q - p).cross(r - p).normalized();
          hit.fromOutside = hit.normal.dot(ray.direction) < 0;
        }
      }
    });
  }
  if (!any) return std::nullopt;
  return hit;
}

}  // namespace argil::render
