#pragma once
// Vertices of cells at creases, eight cells at once: the two faces among the planes around each, followed to where they
// meet.

#include <cstdint>

#include "clay/kernels/crease_kernels.h"

namespace argil::clay {

/// Planes of cells, as records of four floats: the point of the plane that is nearest to the cell's middle and the mean
/// square of what the plane leaves of the cell's corners (`bend`, voxels²; kNoPlane where a cell is too flat or too far
/// from the surface to say where that is); the unit normal and how far the slope is from 1 (`blur`: a cell on a crease
/// may look like a plane between its faces, but not as steep as one).
struct BlockPlanes {
  static constexpr int kMost = kBlockCells * kBlockCells * kBlockCells, kPadding = 16;
  enum { bend = 3, blur = 3 };
  int count = 0;
  alignas(64) float foot[kMost + kPadding][4], normal[kMost + kPadding][4];
};
inline constexpr float kNoPlane = 1e9f;

/// A cell by where its lowest corner is in a block of voxels: x · 256 + y · 16 + z.
using BlockCell = uint16_t;

/// Planes of `count` cells of a block of voxels `phi`, `stepX` and `stepY` apart along x and y; behind them stands one
/// that is none. Feet are in voxels from the block's voxel `margin`, `margin`, `margin`. `cells` can be read up to
/// kPadding past the last.
void cellPlanes(const float* phi, int stepX, int stepY, int margin, const BlockCell* cells, int count,
                BlockPlanes& out) noexcept;

/// Which planes count, and when two faces are told by them.
struct CrispRule {
  float most;     ///< Planes that bend by less (RMS, voxels): by 1 where they do not, by 0 from there on.
  float blurred;  ///< How much blur counts as a bend (voxels²).
  float share;    ///< There must be so many of those that bend by less than kCurvedPlane.
  float least;    ///< Each face has so many planes.
};
inline constexpr float kCurvedPlane = 0.04f;
/// How much a plane counts by such a rule.
[[nodiscard]] float planeQuality(float bend, float blur, const CrispRule& rule) noexcept;

/// Up to eight cells, with the planes around each.
inline constexpr int kCrispCells = 8, kMostNearPlanes = 64;
struct CrispCells {
  int count = 0;
  int stepX = 0, stepY = 0;
  const float* phi[kCrispCells];  ///< Its lowest corner's distance, in the block of voxels.
  float low[3][kCrispCells];      ///< And place.
  float draft[3][kCrispCells];    ///< Its vertex so far, from there.
  uint32_t edges[kCrispCells];    ///< Its crossed edges, as clay/kernels/cell_cases.h numbers them.
  const CrispRule* rule[kCrispCells];
  int planes[kCrispCells];  ///< How many.
  uint16_t plane[kCrispCells][kMostNearPlanes];
};

/// 1 − cos 25°: faces that meet flatter than this stay as the draft has them, at most 0.11 voxel off.
inline constexpr float kLeastTurn = 0.094f;
/// How far a vertex may lie outside of its cell, in voxels along an axis.
inline constexpr float kCrispReach = 0.5f;

/// A cell in a rounding of two voxels bends by less than the first (RMS, voxels), and the plane through its corners has
/// a slope above the second.
inline constexpr float kCreaseBend = 0.09f, kCreaseSlope = 0.93f;

/// Bits by cell.
struct CrispVertices {
  unsigned kinked;     ///< A crease goes through the cell, by kCreaseBend and kCreaseSlope.
  unsigned edge;       ///< The vertex is on the crease, where edges of the cell cross both faces,
  unsigned face;       ///< or on the face that they cross.
  unsigned third;      ///< Planes of neither face have a tenth of the weight.
  unsigned curved;     ///< One of the faces turns within the reach of its planes.
  unsigned explained;  ///< The cell is inside and outside as the faces say, and nearly as far.
  /// How far the crease stands off the surface, voxels, in the mean over voxels beside it, as it would at a right
  /// angle: a rounding of a voxel has 0.15. Of edges and faces.
  alignas(64) float rounding[kCrispCells];
  alignas(64) float along[3][kCrispCells];     ///< The crease's direction, unit.
  alignas(64) float position[3][kCrispCells];  ///< From `low`.
  alignas(64) float normal[3][kCrispCells];    ///< The faces' sum: of any length.
  alignas(64) float crease[3][kCrispCells];    ///< The point of the crease that is nearest to a vertex on a face.
};
/// Where the two faces that meet in each cell cross: the live grade's step, for creases between curved faces too. A
/// cell gets no vertex where there are no four planes, where two faces are not told apart, or where its own values
/// contradict them. Writes behind the last cell and the last planes. Equal bits on all targets. O(cells of eight · the
/// most planes that one of them has).
void placeCrisply(CrispCells& cells, const BlockPlanes& planes, CrispVertices& out) noexcept;

}  // namespace argil::clay
