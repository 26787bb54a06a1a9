#pragma once
// Where the halves of a mould meet: one height for each place across the pull.

#include <vector>

#include "clay/base/vec.h"
#include "clay/base/work_part.h"

namespace argil::clay {

/// Places one voxel apart, x the faster. `bottom` and `top`: of what is moulded, NaN where there is none of it.
struct MouldColumns {
  int width = 0, height = 0;
  std::vector<float> bottom, top;  ///< Voxels along the pull.
  [[nodiscard]] size_t index(int x, int y) const { return size_t(y) * size_t(width) + size_t(x); }
  [[nodiscard]] bool covered(size_t i) const { return bottom[i] == bottom[i]; }
};

/// The smoothest heights that pass between bottom and top wherever there is something: of least squared slope (a
/// membrane), flat across the edges of the block. Where the sides of the shape stand upright the line is free, and lies
/// as straight as it can. One height a column, voxels. Solved from coarse to fine by over-relaxation with the bounds
/// held (Young 1971; multigrid's nested iteration). At most kMostPlaces along a side are solved, those between are
/// interpolated. Throws Cancelled. Cost: sixty sweeps over the columns, and a
/// third of that on coarser ones; one thread.
[[nodiscard]] std::vector<float> partingHeights(const MouldColumns& columns, const WorkPart& part);
inline constexpr int kMostPlaces = 1024;

}  // namespace argil::clay
