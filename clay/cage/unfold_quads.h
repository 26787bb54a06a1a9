#pragma once
// Quads without corners that bend inwards.

#include "clay/cage/crease_map.h"
#include "clay/cage/quad_mesh.h"
#include "clay/mesh/nearest_triangle.h"

namespace argil::clay {

/// Vertices around quads whose scaled Jacobian is below a third, or that face inwards, move along the surface (and
/// those of creases along these) to where the worst quad around them is best; corners stay. What is good stays as it
/// is. No quad becomes worse than the worst of those around a vertex that moves. One thread; about 0.1 ms a bad quad.
void unfoldQuads(QuadMesh& mesh, const TriangleMesh& surface, const NearestTriangle& tree, const CreaseMap& creases);

}  // namespace argil::clay
