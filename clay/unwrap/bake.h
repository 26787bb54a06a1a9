#pragma once
// What a mesh of few quads does not show of its clay, as pictures.

#include <array>
#include <cstdint>
#include <functional>
#include <vector>

#include "clay/base/work_part.h"
#include "clay/cage/quad_mesh.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/store/version.h"
#include "clay/unwrap/unwrap.h"

namespace argil::clay {

/// Directions at the places of a UvMap, of length 1: out of the surface, and along the picture's x.
struct UvFrames {
  std::vector<uint32_t> vertices;  ///< Of the mesh, of each place.
  std::vector<Vec3d> normals, tangents;
};
[[nodiscard]] UvFrames framesOf(const QuadMesh& mesh, const UvMap& map);

struct BakedPictures {
  int pixels = 0;                 ///< Of each side; rows from the top.
  std::vector<uint8_t> normals;   ///< Three bytes a pixel: x, y, z of the clay's normal along tangent, bitangent and
                                  ///< normal of the mesh, from −1 to 1 as 0 to 255 (glTF's and OpenGL's way).
  std::vector<uint8_t> colours;   ///< Three bytes a pixel, sRGB; empty without `colourAt`.
  std::vector<uint16_t> heights;  ///< The clay above the mesh along its normal: −heightMm to heightMm as 0 to 65 535.
  double heightMm = 0;
  double missed = 0;  ///< Of the mesh's pixels: the clay was not met along the normal, and its nearest place was taken.
};

/// For each pixel of the mesh the place of the clay that its normal meets first, either way. Around charts the pictures
/// go on with what is nearest, so that nothing shines through at seams. `surface`, which `tree` searches: the clay's.
/// `colourAt`: sRGB at a place in a triangle of it; may be null. The same for any count of threads. Throws Cancelled.
/// Cost: half a µs a pixel of the mesh and thread, 1.3 with colours.
[[nodiscard]] BakedPictures baked(
    const Version& version, const TriangleMesh& surface, const NearestTriangle& tree, const QuadMesh& mesh,
    const UvMap& map, int pixels,
    const std::function<std::array<uint8_t, 3>(uint32_t triangle, const Vec3d& at)>& colourAt, int threads,
    const WorkPart& part);

}  // namespace argil::clay
