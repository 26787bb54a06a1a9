#pragma once
// The surface in one brick coordinate: its vertices, then its quads.

#include <array>
#include <cstdint>
#include <span>

#include "clay/kernels/surface_kernels.h"
#include "clay/store/sampler.h"
#include "clay/surface/surface.h"

namespace argil::clay {

/// What the extraction of one brick reads.
struct BrickInput {
  Slot slots[2][2][2];  ///< At its coordinate and one step higher along each axis, as [x][y][z].
  float step = 0;       ///< Of the version's bricks.
  BrickSigns signs;
  bool crossed = false;  ///< Some cell is active.
  /// Bit y: the row of voxels, and its ninth value, is a corner of active cells. Only when crossed.
  uint16_t rows[9], ends[9];
};

/// From `slots`: the signs.
void readSigns(BrickInput& input);
/// From the signs: the rest. Sends for the voxels that will be read, so call it a few bricks ahead of extractVertices.
void readRows(BrickInput& input);

/// How the cells of a brick number their vertices. A cell's first loop has its rank among the active cells; further
/// loops come after all of those.
struct CellTable {
  /// A cell with more than one loop, or one that reads its folded face the other way.
  struct Special {
    uint16_t cell;  ///< x·64 + y·8 + z.
    uint8_t pattern;
    bool joined;
    uint16_t extraFirst;  ///< Index of its second loop's vertex.
    friend bool operator==(const Special&, const Special&) = default;
  };
  uint64_t active[8];  ///< Bit y·8 + z of word x: the cell has a vertex.
  uint16_t before[8];  ///< Active cells in the words before.
  uint16_t vertices = 0;
  uint16_t quads = 0;  ///< Voxel edges with a sign change from the brick's own voxels.
  /// Some vertices depend on voxels beyond their cells, in any brick around: of a cell with a folded face or, in the
  /// crisp grade, with a kink.
  bool readsBeyond = false;
  std::span<const Special> specials;  ///< In order of cell.
  std::span<const uint16_t> sharp;    ///< Vertices on creases, in order.

  friend bool operator==(const CellTable& a, const CellTable& b);

  /// The vertex of a cell that holds one of its crossed edges.
  [[nodiscard]] uint32_t vertexOf(int cell, int edge) const;
};

/// Room for one brick on its way: for the most there can be, and for whole vectors past the last.
struct ExtractionBuffer {
  static constexpr size_t kMostVertices = 4 * kBrickVoxels + kCellPadding;
  CellTable table;
  std::array<CellTable::Special, kBrickVoxels> specials;
  std::array<uint16_t, kMostVertices> sharp;
  std::array<Vec3f, kMostVertices> positions;
  std::array<PackedNormal, kMostVertices> normals;
  std::array<std::array<VertexRef, 4>, 3 * kBrickVoxels + kEdgePadding> quads;
};

/// Vertices of the cells of `brick` into out.table, positions and, when asked for, normals; out.table.vertices may be
/// 0. `field` reads the same version, for the rare cells that look beyond.
void extractVertices(Sampler& field, const Coord& brick, const BrickInput& input, bool wantNormals, Grade grade,
                     ExtractionBuffer& out);

/// What extractQuads needs of a brick coordinate and of its seven lower neighbours; null tables have no vertices.
struct VertexSource {
  const CellTable* table = nullptr;
  const Vec3f* positions = nullptr;
};

/// Quads of the voxel edges whose lower voxel is in the brick of `signs`, into out.quads: `sources[0].table->quads` of
/// them; `sources[dx·4 + dy·2 + dz]` is the brick that is dx, dy, dz lower. Each is split along its shorter diagonal,
/// or along a crease.
void extractQuads(const BrickSigns& signs, const std::array<VertexSource, 8>& sources, ExtractionBuffer& out);

}  // namespace argil::clay
