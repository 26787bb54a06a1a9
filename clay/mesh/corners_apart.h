#pragma once
// Triangles whose corners would lie in one place in a file of 32-bit numbers.

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <span>
#include <vector>

#include "clay/mesh/triangle_mesh.h"

namespace argil::clay {

/// A mesh piece by piece: its next vertices, the first of which has this number, and triangles of these vertices and of
/// the piece before.
using MeshPiece = std::function<void(uint32_t first, std::span<const Vec3d> positions,
                                     std::span<const std::array<uint32_t, 3>> triangles)>;
/// Calls a visitor with each piece, in order; the same ones each time.
using MeshPieces = std::function<void(const MeshPiece& visit)>;

/// Returns new places for the fewest vertices, by number, so that the corners of each triangle stay apart when
/// coordinates become 32-bit numbers, as they are, about the middle of the mesh, or in another unit. Vertices move by
/// at most a 100 000th of the largest coordinate. Triangles that name a vertex twice are left as they are. Cost: three
/// passes over most meshes.
[[nodiscard]] std::map<uint32_t, Vec3d> cornersApart(const MeshPieces& pieces);

/// Moves these vertices of a whole mesh; gives their number.
size_t moveCornersApart(TriangleMesh& mesh);

/// Marks the triangles that have two corners in one place, as the same vertex or as two.
[[nodiscard]] std::vector<bool> haveOnePlaceTwice(const TriangleMesh& mesh);

}  // namespace argil::clay
