#pragma once
// Quads of one half of a clay and their mirror images.

#include <array>
#include <optional>
#include <vector>

#include "clay/cage/crease_map.h"
#include "clay/cage/quad_mesh.h"
#include "clay/mesh/nearest_triangle.h"

namespace argil::clay {

/// A plane that is normal to an axis.
struct MirrorPlane {
  int axis = 0;     ///< 0 to 2: x, y, z.
  double atMm = 0;  ///< Along the axis.

  [[nodiscard]] Vec3d imageOf(Vec3d p) const {
    p[axis] = 2 * atMm - p[axis];
    return p;
  }
};

/// The first axis whose plane through the middle of a surface, which `tree` searches, mirrors it: the images of all its
/// vertices lie within `withinMm` of it. Cost: some µs a vertex, where a few are enough to refuse.
[[nodiscard]] std::optional<MirrorPlane> mirrorPlaneOf(const TriangleMesh& surface, const NearestTriangle& tree,
                                                       double withinMm);

/// All four corners.
[[nodiscard]] bool liesIn(const QuadMesh& mesh, const std::array<uint32_t, 4>& quad, const EndPlane& end);

struct MirroredQuads {
  QuadMesh mesh;
  std::vector<uint32_t> image;  ///< Of each vertex; its own in the plane.
};

/// Moves each vertex to the mean of itself and its image's image, or into the plane: mirrored to the bit. `image` as in
/// MirroredQuads.
void makeMirrored(QuadMesh& mesh, const std::vector<uint32_t>& image, const MirrorPlane& plane);

/// `half`: a closed mesh around the half of a clay below a plane, whose creases part what lies in its `end` from the
/// rest. That goes, the rest is joined to its mirror image in the plane at `atMm`, which may lie a little beyond.
/// Creases in the plane stay where `creases`, those of the whole clay, has one near. Nothing where something else lies
/// in the end than parts between creases, or what it makes is not closed.
[[nodiscard]] std::optional<MirroredQuads> mirroredQuads(const QuadMesh& half, const EndPlane& end,
                                                         const MirrorPlane& plane, const CreaseMap& creases);

}  // namespace argil::clay
