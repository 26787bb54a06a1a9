#pragma once
// A closed mesh of quads in few parts that can be laid flat.

#include <array>
#include <cstdint>
#include <vector>

#include "clay/base/work_part.h"
#include "clay/cage/quad_mesh.h"
#include "clay/mesh/triangle_mesh.h"
#include "clay/unwrap/flatten.h"

namespace argil::clay {

/// Quads that are joined along some of their edges; all others are seams, also between two quads of the chart: a tube
/// is cut along its length. Each of its vertices has one place on the flat, so one of the mesh may be several here.
struct Chart {
  std::vector<uint32_t> quads;                    ///< Of the mesh, ascending.
  std::vector<std::array<uint32_t, 4>> vertices;  ///< Of each of them, in the order of its corners.
  SurfaceDisk disk;                               ///< Two triangles a quad, in the order of the quads.
  FlatDisk flat;
};

/// Charts of all quads, few and none stretched by more than it must be: quads are joined as long as a chart keeps
/// within `stretch` (FlatDisk::stretch, above 1) and passes over itself nowhere; what cannot be joined stays alone.
/// Less stretched ones are tried first, and it ends where there are no more than `few`. Throws Error for a mesh that is
/// not closed or has no area; Cancelled. Cost: 1 to 2 ms a quad on one thread. The same on any number of threads.
[[nodiscard]] std::vector<Chart> chartsOf(const QuadMesh& mesh, double stretch, size_t few, int threads,
                                          const WorkPart& part);

}  // namespace argil::clay
