#pragma once
// The surface in one brick coordinate: its vertices, then its quads.

#include <array>
#include <cstdint>
#include <vector>

#include "clay/sampler.h"
#include "clay/surface.h"

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

/// Vertices of the cells of `brick` into `positions` and, when asked for, `normals` (both empty on entry; they stay empty where
/// there is no surface).
void extractVertices(Sampler& field, Coord brick, bool wantNormals, CellTable& table, std::vector<Vec3f>& positions,
                     std::vector<PackedNormal>& normals);

/// What extractQuads needs of a brick coordinate and of its seven lower neighbours; null tables have no vertices.
struct VertexSource {
  const CellTable* table = nullptr;
  const Vec3f* positions = nullptr;
};

/// Quads of the voxel edges whose lower voxel is in `brick`; `sources[dx·4 + dy·2 + dz]` is the brick that is dx, dy, dz lower.
/// Appends to `quads`, each split along its shorter diagonal.
void extractQuads(Sampler& field, Coord brick, const std::array<VertexSource, 8>& sources, std::vector<std::array<VertexRef, 4>>& quads);

}  // namespace argil::clay
