#pragma once
// Cells around a brick that lie on one face: which, and whether they face one way.

#include <cstdint>

namespace argil::clay {

/// Cells of a block of 12³: bit z of [x][y].
inline constexpr int kBlockCells = 12;
using BlockCells = uint16_t[kBlockCells][kBlockCells];
/// How far cells bend: the RMS misfit of a plane to the eight corners, voxels.
struct CellBends {
  float slight, strong;  ///< More than these.
  float flat;            ///< Those that bend by less lie on one face.
};
/// Cells by how they bend, and the planes of those that lie on one face, by x, y, z. None has a cell that has hardly a
/// slope, or that is so far from the surface that it sees other faces too.
struct CellFits {
  static constexpr int kRow = 16;
  using Row = float[kBlockCells][kBlockCells][kRow];
  BlockCells slight, strong, flat;
  alignas(64) Row quality;   ///< How much the plane counts: from 1, where nothing bends, to 0, where there is none.
  alignas(64) Row x, y, z;   ///< Its unit normal, outwards.
  alignas(64) Row distance;  ///< Of the cell's middle from it, voxels.
};
/// Fits the cells of a block of 13³ voxels `phi`, `stepX` and `stepY` apart along x and y.
void fitCells(const float* phi, int stepX, int stepY, const CellBends& bends, CellFits& out) noexcept;

/// Whether no normal of the cells up to two steps away from a cell, along each axis, is turned by `most` (1 − the
/// cosine) or more from the one that is heaviest by its quality and the fourth power of its middle's distance from `p`.
/// `p` is given from the middle of cell 0, 0, 0.
[[nodiscard]] bool normalsAgree(const CellFits& fits, int x, int y, int z, const float* p, float most) noexcept;

}  // namespace argil::clay
