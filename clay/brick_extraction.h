#pragma once
// The surface in one brick coordinate: its vertices, then its quads.

#include <array>
#include <cstdint>
#include <vector>

#include "clay/sampler.h"
#include "clay/surface.h"
#include "clay/surface_kernels.h"

namespace argil::clay {

/// How the cells of a brick number their vertices. A cell's first loop has its rank among the active cells; further loops
/// come after all of those.
struct CellTable {
  /// A cell with more than one loop, or one that reads its folded face the other way.
  struct Special {
    uint16_t cell;        ///< x·64 + y·8 + z.
    uint8_t pattern;
    bool joined;
    uint16_t extraFirst;  ///< Index of its second loop's vertex.
    friend bool operator==(const Special&, const Special&) = default;
  };
  uint64_t active[8] = {};   ///< Bit y·8 + z of word x: the cell has a vertex.
  uint16_t before[8] = {};   ///< Active cells in the words before.
  uint64_t special[8] = {};  ///< Cells listed in `specials`.
  std::vector<Special> specials;  ///< In order of cell.
  uint16_t vertices = 0;
  /// Some cell has a folded face: its vertices depend on the cells beyond, one brick lower too.
  bool folded = false;

  friend bool operator==(const CellTable& a, const CellTable& b);

  /// The vertex of a cell that holds one of its crossed edges.
  [[nodiscard]] uint32_t vertexOf(int cell, int edge) const;
};

/// Vertices of one brick on their way: room for the most there can be, and for whole vectors past the last.
struct VertexBuffer {
  static constexpr size_t kMost = 4 * kBrickVoxels + kCellPadding;
  std::array<Vec3f, kMost> positions;
  std::array<PackedNormal, kMost> normals;
  size_t count = 0;
  [[nodiscard]] std::span<const Vec3f> usedPositions() const { return {positions.data(), count}; }
  [[nodiscard]] std::span<const PackedNormal> usedNormals() const { return {normals.data(), count}; }
};

/// Vertices of the cells of `brick`, with normals when asked for; none where there is no surface.
void extractVertices(Sampler& field, Coord brick, bool wantNormals, CellTable& table, VertexBuffer& out);

/// What extractQuads needs of a brick coordinate and of its seven lower neighbours; null tables have no vertices.
struct VertexSource {
  const CellTable* table = nullptr;
  const Vec3f* positions = nullptr;
};

/// Quads of one brick: three edges a voxel at the most.
struct QuadBuffer {
  std::array<std::array<VertexRef, 4>, 3 * kBrickVoxels> quads;
  size_t count = 0;
  [[nodiscard]] std::span<const std::array<VertexRef, 4>> used() const { return {quads.data(), count}; }
};

/// Quads of the voxel edges whose lower voxel is in `brick`; `sources[dx·4 + dy·2 + dz]` is the brick that is dx, dy, dz lower.
/// Each is split along its shorter diagonal.
void extractQuads(Sampler& field, Coord brick, const std::array<VertexSource, 8>& sources, QuadBuffer& out);

}  // namespace argil::clay
