#pragma once
// Flat quads that lie as near to a surface as they come.

#include "clay/base/work_part.h"
#include "clay/cage/crease_map.h"
#include "clay/cage/quad_mesh.h"
#include "clay/mesh/nearest_triangle.h"

namespace argil::clay {

/// Moves the vertices of a closed mesh, along the surface hardly, until its quads lie around the surface that `tree`
/// searches and not only inside it, as those do whose corners are on it: least squares both ways, over nine places of
/// each quad's two triangles (trianglesOf) and 20 000 vertices of the surface, or as many as places where those are
/// more, with what lies far off counting more. `corners`: the quads' own corners count as places do; else they may
/// stand off as far as that brings edges near. No scaled Jacobian of a quad falls below 0.25, or below what it was.
/// Vertices of the mesh's creases stay on those of the surface, its corners where they are. Throws Cancelled. Cost:
/// five times a search for what is nearest to each place and vertex, and some twenty steps of conjugate gradients. The
/// same for any count of threads.
void fitQuads(QuadMesh& mesh, const TriangleMesh& surface, const NearestTriangle& tree, const CreaseMap& creases,
              int threads, const WorkPart& part, bool corners = false);

}  // namespace argil::clay
