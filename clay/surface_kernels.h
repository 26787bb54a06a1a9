#pragma once
// Arithmetic of surface extraction on many cells at once; compiled once per SIMD target.

#include <cstdint>

#include "clay/vec.h"

namespace argil::clay {

/// The voxels that the cells of a brick touch: [x][y][z] at (x·9 + y)·9 + z, 0 to 8 along each axis.
inline constexpr int kCornerRow = 9;
inline constexpr int kCornerCount = 9 * 9 * kCornerRow;
inline constexpr int cornerOffset(int x, int y, int z) { return (x * 9 + y) * kCornerRow + z; }

/// Outputs of cellVertices may be written up to this many elements past the last cell.
inline constexpr int kCellPadding = 16;

/// For each of `count` cells (x·64 + y·8 + z): its corner pattern; the mean of its edge crossings relative to the brick, three
/// floats; and, unless null, the normal there, as PackedNormal's two 16-bit numbers. Right for cells with one loop; the caller
/// mends the others. `cells` must be readable, with valid cells, up to the next multiple of kCellPadding. Equal bits on every target:
/// edges are summed in the order of kCellEdges.
void cellVertices(const float* corners, const uint16_t* cells, int count, uint32_t* patterns, float* positions, uint32_t* normals) noexcept;

}  // namespace argil::clay
