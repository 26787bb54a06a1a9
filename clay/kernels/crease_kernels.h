#pragma once
// Tangent planes around a crease: found for many cells at once, told apart by their faces, followed to the crease.

#include <cstdint>

namespace argil::clay {

/// Planes of cells, as rows of floats: the point of the plane that is nearest to the cell's middle, the unit normal,
/// and the mean square of what the plane leaves of the cell's corners (`bend`, voxels²; kNoPlane where a cell is too
/// flat or too far from the surface to say where that is). A cell on a crease may look like a plane between its faces,
/// but not as steep as one: `blur` is how far its slope is from 1.
template <int most>
struct CreasePlanes {
  alignas(64) float foot[3][most], normal[3][most], bend[most], blur[most];
};
inline constexpr float kNoPlane = 1e9f;

/// Planes of all cells around a brick, and those that one cell looks at.
inline constexpr int kMostBrickPlanes = 12 * 12 * 12, kMostNearPlanes = 64;
using BrickPlanes = CreasePlanes<kMostBrickPlanes>;
/// Elements past the last that may be read and written, in all functions here.
inline constexpr int kPlanePadding = 16;

/// A cell by where its lowest corner is in a block of voxels: x · 256 + y · 16 + z.
using BlockCell = uint16_t;

/// Planes of `count` cells of a block of voxels `phi`, `stepX` and `stepY` apart along x and y. Feet are in voxels from
/// the block's voxel `margin`, `margin`, `margin`. `cells` can be read up to the padding.
void cellPlanes(const float* phi, int stepX, int stepY, int margin, const BlockCell* cells, int count,
                BrickPlanes& out) noexcept;

/// Cells of a block of 12³: bit z of [x][y].
inline constexpr int kBlockCells = 12;
using BlockCells = uint16_t[kBlockCells][kBlockCells];
/// How far cells bend: the RMS misfit of a plane to the eight corners, voxels.
struct CellBends {
  float slight, strong;  ///< More than these.
  float flat, near;      ///< No more than `flat`, with a mean of the corners below `near`.
};
struct SortedCells {
  BlockCells slight, strong, flatNear;
};
/// Sorts the cells of a block of 13³ voxels `phi`, `stepX` and `stepY` apart along x and y.
void sortCells(const float* phi, int stepX, int stepY, const CellBends& bends, SortedCells& out) noexcept;

/// Planes of these cells, by x, y, z: how much each counts, 0 where there is none, and its unit normal.
struct BlockNormals {
  static constexpr int kRow = 16;
  using Row = float[kBlockCells][kBlockCells][kRow];
  alignas(64) Row quality{};
  alignas(64) Row x, y, z;  // (not cleared: that would take longer than what is read of them)
};
/// Whether no normal of the cells up to two steps away from a cell, along each axis, is turned by `most` (1 − the
/// cosine) or more from the one that is heaviest by its quality and the fourth power of its middle's distance from `p`.
/// `p` is given from the middle of cell 0, 0, 0.
[[nodiscard]] bool normalsAgree(const BlockNormals& normals, int x, int y, int z, const float* p, float most) noexcept;

/// Planes that one cell looks at. `weight` is zero behind the last and where a plane counts for nothing.
struct NearPlanes : CreasePlanes<kMostNearPlanes> {
  alignas(64) float quality[kMostNearPlanes], weight[kMostNearPlanes];
  alignas(64) float member[2][kMostNearPlanes];  ///< 1 where the plane is of this face, else 0.
  int count = 0, padded = 0;
};

/// Takes `count` of `all`, by their indices, with their feet moved by −`low`. `indices` can be read up to the padding.
void pickPlanes(const BrickPlanes& all, const uint16_t* indices, int count, const float* low, NearPlanes& out) noexcept;
/// Quality of planes that bend by less than `most` (voxels): 1 where they do not, 0 from there on; `steep`: those that
/// are blurred have less. Returns how many have one.
enum class PlaneTrust : uint8_t { steep, any };
int ratePlanes(NearPlanes& planes, float most, PlaneTrust trust) noexcept;

/// How planes are told apart: by 1 − the cosine of the angle between normals.
struct FaceTurns {
  float least;  ///< Two faces are turned by more.
  float most;   ///< A plane that is turned from its face by more is none of it.
  float third;  ///< Part of the weight that planes of neither face have where there is a third one.
};
/// A face as one plane.
struct FacePlane {
  float normal[3], foot[3];  ///< Means over its planes, by their weight: the normal is shorter than 1 where they turn.
};
struct SplitFaces {
  FacePlane face[2];
  int count[2]{}, planes = 0;  ///< That count for each, and in all.
  bool found = false, third = false;
};
/// Two faces by their normals: the heaviest plane's, and that of the heaviest plane turned from it. Weights fall with
/// the fourth power of the distance from `p`. Writes weights and members of `planes`.
SplitFaces splitPlanes(NearPlanes& planes, const float* p, const FaceTurns& turns) noexcept;

/// Face `which` as it is at `p`: the unit normal, and its distance at zero. By second order: between two points of a
/// smooth surface the chord is perpendicular to the mean of their normals, but for an error of third order, and the
/// normal at `p` follows from how normals turn towards it. Planes cut off what a face curves within their cells: the
/// face stands out of them by that.
struct FaceThere {
  float normal[3], offset, foot[3];
};
FaceThere faceAt(NearPlanes& planes, int which, const float* p) noexcept;

}  // namespace argil::clay
