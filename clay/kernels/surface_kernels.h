#pragma once
// Arithmetic of surface extraction on many cells at once; compiled once per SIMD target, equal bits on every one.

#include <cstdint>

#include "clay/base/vec.h"

namespace argil::clay {

/// The signs of a brick and what they cross. Bit y·8 + z of word x stands for a voxel, for the cell or the edge that it
/// begins.
struct BrickSigns {
  uint64_t inside[8];
  uint64_t active[8];      ///< Cells with both signs among their corners.
  uint64_t crossed[3][8];  ///< Edges along each axis from a voxel to the next, which may be in the next brick.
};

/// Sign words, in the layout of Brick::inside, of a brick and of those one step higher: own[dy·2 + dz] are eight words,
/// next[dy·2 + dz] the first word of those higher in x.
struct SignWords {
  const uint64_t* own[4];
  uint64_t next[4];
};
void brickSigns(const SignWords& words, BrickSigns& out) noexcept;

/// Positions of the bits that are set in eight words, x·64 + bit, in order; returns how many. Up to kListPadding
/// elements past the last may be written.
int listBits(const uint64_t* words, uint16_t* out) noexcept;
inline constexpr int kListPadding = 16;

/// Steps along x, y, z in a map of the cells of a brick and of those one lower: −1 to 7 along each axis.
inline constexpr int kMapStep[3] = {81, 9, 1};
inline constexpr int mapPlace(int x, int y, int z) {
  return (x + 1) * kMapStep[0] + (y + 1) * kMapStep[1] + (z + 1) * kMapStep[2];
}
inline constexpr uint16_t kEdgeDown = 1u << 15;
/// The same of the edges of a brick that are crossed, as edgeQuads() takes them: the place in the map of the cell at
/// the lower end, with kEdgeDown where that end is outside. Words as those of BrickSigns.
int listEdges(const uint64_t* crossed, const uint64_t* inside, uint16_t* out) noexcept;

/// The voxels that the cells of a brick touch: [x][y][z] at (x·9 + y)·9 + z, 0 to 8 along each axis.
inline constexpr int kCornerRow = 9;
inline constexpr int kCornerCount = 9 * 9 * kCornerRow;
inline constexpr int cornerOffset(int x, int y, int z) {
  return (x * 9 + y) * kCornerRow + z;
}

/// Outputs of cellVertices may be written up to this many elements past the last cell.
inline constexpr int kCellPadding = 16;

/// For each of `count` cells (x·64 + y·8 + z): its corner pattern; the mean of its edge crossings relative to the
/// brick, three floats; and, unless null, the normal there, as PackedNormal's two 16-bit numbers. Right for cells with
/// one loop; the caller repairs the others, whose patterns are the bits that are set in the eight words of `unusual`.
/// False: there are none of these, nor of what `kinks` asks for. With `kinks` the pattern of a cell that a crease is
/// likely to cross has kKinkedCell set: its field is no plane of slope 1, as that of a distance is away from creases;
/// and kBentCell where the field is no plane: beside such cells a crease may cross it too. `cells` must be readable,
/// with valid cells, up to the next multiple of kCellPadding. Edges are summed in the order of kCellEdges.
bool cellVertices(const float* corners, const uint16_t* cells, int count, bool kinks, const uint32_t* unusual,
                  uint32_t* patterns, float* positions, uint32_t* normals) noexcept;
inline constexpr uint32_t kKinkedCell = 1u << 8, kBentCell = 1u << 9;
/// RMS misfit of a plane to the eight corners of a bent cell, voxels, and of a kinked one: that of a sphere of ten and
/// of three. Two faces may meet so that the corners lie in a plane; it then has the mean of their slopes. In a cell
/// that bends the second one is enough: a ball of two and a half voxels has more.
inline constexpr float kBentBend = 0.013f, kKinkedBend = 0.04f, kKinkedSlope = 0.88f, kBentSlope = 0.96f;

/// A vertex as the quads of a brick use it: relative to that brick, and how they name it.
struct alignas(16) CellVertex {
  float x, y, z;
  /// kRefTag and a VertexRef. (The tag makes it a number that arithmetic on all four may meet at full speed.)
  uint32_t ref;
};
inline constexpr uint32_t kRefTag = 0x3f800000;

/// Puts the vertices of a brick's cells into its map (mapPlace): number i of `positions`, three floats each, to the
/// cell of the i-th bit of `active`, its `ref` i on top of `refs`.
void placeCells(const float* positions, const uint64_t* active, uint32_t refs, CellVertex* map) noexcept;

/// Edges past the last that must be readable and valid, and quads past the last that may be written.
inline constexpr int kEdgePadding = 3;

/// The quads of `count` voxel edges along one axis as four VertexRefs each; a corner of the shorter diagonal
/// first, counter-clockwise from outside. edges[i] is where `vertices` has the cell at the edge's lower voxel, with
/// kEdgeDown when the edge leads from outside to inside; the cells around it lie `stepU` and `stepV` before, along the
/// two axes after its own.
void edgeQuads(const CellVertex* vertices, const uint16_t* edges, int count, int stepU, int stepV,
               uint16_t* quads) noexcept;

/// Bit y·8 + z of word x: the two bricks' values differ in that voxel.
void differingVoxels(const float* a, const float* b, uint64_t (&out)[8]) noexcept;

}  // namespace argil::clay
