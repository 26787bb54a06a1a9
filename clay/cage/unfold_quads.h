#pragma once
// Quads without corners that bend inwards.

#include "clay/base/work_part.h"
#include "clay/cage/crease_map.h"
#include "clay/cage/quad_mesh.h"
#include "clay/mesh/nearest_triangle.h"

namespace argil::clay {

/// Quads whose scaled Jacobian is below 0.35, or that face inwards: their vertices and those of the quads beside them
/// move along the surface (those of creases along these; corners stay) to where quads are better. Bad bodies of six
/// quads without creases become boxes around their clay. Where nothing is bad nothing moves. One thread; cost follows
/// the bad quads.
void unfoldQuads(QuadMesh& mesh, const TriangleMesh& surface, const NearestTriangle& tree, const CreaseMap& creases,
                 const WorkPart& part);

}  // namespace argil::clay
