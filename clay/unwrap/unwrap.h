#pragma once
// Places on a picture for a mesh of quads (UVs).

#include <array>
#include <cstdint>
#include <vector>

#include "clay/base/work_part.h"
#include "clay/cage/quad_mesh.h"
#include "clay/unwrap/flatten.h"

namespace argil::clay {

struct UvMap {
  std::vector<Vec2d> places;                     ///< 0 to 1, from the picture's lower left corner.
  std::vector<std::array<uint32_t, 4>> corners;  ///< Of each quad, in the order of its corners.
  std::vector<uint32_t> chart;                   ///< Of each quad, from 0.
  size_t charts = 0;
  double stretch = 1;   ///< As FlatDisk::stretch, over all charts.
  double covered = 0;   ///< Of the picture.
  double mmOfSide = 0;  ///< What the picture's side is on the surface, mm.
};

struct UnwrapOptions {
  double stretch = 1.05;      ///< Of no chart more, above 1.
  size_t few = 15;            ///< So few charts are enough.
  double margin = 1.0 / 512;  ///< Between charts, of the picture's side: 4 pixels of 2 048.
  int threads = 2;
};

/// Charts that nothing is folded in or lies on another: each place of the picture belongs to one place of the mesh at
/// most. One scale for all. Quads without an area get a little. Throws Error for a
/// mesh that is not closed or has no area; Cancelled. Cost: 1 to 2 ms a quad on one thread, and one to three seconds.
/// The same on any number of threads.
[[nodiscard]] UvMap unwrapped(const QuadMesh& mesh, const UnwrapOptions& options, const WorkPart& part);

}  // namespace argil::clay
