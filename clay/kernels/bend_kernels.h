#pragma once
// Where a bent surface crosses the edges of a cell, and its normals there.

#include <cstdint>

namespace argil::clay {

/// Of crossed edges, in the order of their numbers (clay/kernels/cell_cases.h). Elements past `count` hold anything.
struct EdgeCrossings {
  static constexpr int kMost = 12, kPadding = 4;
  int count = 0;
  float least = 0;                            ///< The smallest slope among them (1 in a field of distances).
  alignas(16) float along[kMost + kPadding];  ///< Where, from the edge's first corner: 0 to 1.
  alignas(
      16) float normal[3][kMost + kPadding];  ///< Unit, outwards: along the edge's axis, the next and the one after.
};

/// Crossings of `edges` (bits) of a cell whose lowest corner is at `phi`, by the cubic through four voxels along each
/// edge, and by second differences across it, each from the smooth side alone beside a kink. Reads two voxels around
/// the cell, `stepX`, `stepY` and 1 apart. The field changes its sign along each of the edges. False where it has
/// hardly a slope at one of them. Equal bits on all targets. About 50 ns a cell.
[[nodiscard]] bool crossEdges(const float* phi, int stepX, int stepY, unsigned edges, EdgeCrossings& out) noexcept;

}  // namespace argil::clay
