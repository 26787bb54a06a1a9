#pragma once
// Which faces cross a cell's edges, and the way that the crease between two of them takes through the cells.

#include <array>
#include <cstdint>

#include "clay/surface/crease_model.h"

namespace argil::clay {

/// A cell in a block of voxels.
struct CellView {
  /// The distance at its lowest corner; those of the cells around it, two on each side, may be read too.
  const float* phi;
  int stepX, stepY;           ///< From a voxel to the next along x and y; 1 along z.
  Vec3f low = Vec3f::Zero();  ///< Its lowest corner, in the coordinates of the model that it is compared with.

  /// Bit c: corner c, as clay/kernels/cell_cases.h numbers them, is inside.
  [[nodiscard]] unsigned pattern() const;
  [[nodiscard]] float corner(int c) const { return phi[(c >> 2) * stepX + ((c >> 1) & 1) * stepY + (c & 1)]; }
  /// The cell beyond face axis·2 + side.
  [[nodiscard]] CellView beyond(int face) const;
};

/// What a model makes of the crossed edges of one loop of a cell.
struct Crossings {
  uint16_t edges = 0;            ///< The loop's.
  unsigned faces = 0;            ///< Bit k: face k crosses some of them.
  unsigned firm = 0;             ///< Those of them that cross some edge alone, without a tie.
  std::array<int8_t, 12> of;     ///< The face that crosses each.
  std::array<Vec3f, 12> at;      ///< And where.
  Vec3f middle = Vec3f::Zero();  ///< The mean of the crossings.
};

/// Crossings in the coordinates of cell.low. Faces that cross an edge within `tie` voxels of each other tie there:
/// cells around it may know them that much differently. At a corner, where a single edge may decide, ties within
/// kCornerTie count for all in `faces`.
inline constexpr float kCornerTie = 0.02f;
[[nodiscard]] Crossings crossingsOf(const CellView& cell, uint16_t edges, const CreaseModel& model, float tie);

/// For a cell with crossings on one face: other faces that a neighbour is on, if it may see itself beyond the crease
/// where the cell sees itself before it, so that an edge of the surface would cut the crease off between them. Bit per
/// face.
[[nodiscard]] unsigned contested(const CellView& cell, const Crossings& crossings, const CreaseModel& model, float tie);

/// A place along the line where faces a and b meet for the vertex of a cell whose crossings lie on both: in the order
/// of the cells, as well as a few of them tell. `line` starts anywhere; the result is the distance from there.
/// Neighbouring vertices out of order would fold the triangles between them.
[[nodiscard]] float placeAlong(const CellView& cell, const Crossings& crossings, const CreaseModel& model,
                               const CreaseModel::Line& line, int a, int b);

}  // namespace argil::clay
