#pragma once
// A cage of few quads around a clay.

#include "clay/base/work_part.h"
#include "clay/cage/quad_mesh.h"
#include "clay/store/version.h"

namespace argil::clay {

class Surface;  // clay/surface/surface.h

struct CoarseCage {
  QuadMesh mesh;
  double edgeMm = 0;  ///< About how long its edges are.
  /// Bodies less handles, counted with cavities, of the cage and of the clay: half of the Euler characteristic. Where
  /// they differ the cage has lost a part or closed a hole.
  int64_t shape = 0, clayShape = 0;
};

/// At most `most` quads on the surface, closed, whatever the clay is, and of its shape: the clay's own quads become
/// fewer one by one, and none goes that would change it. Throws Error for empty clay, less than 24 quads, a shape that
/// needs more quads than that; Cancelled. Cost: some seconds for 1 000 quads.
[[nodiscard]] CoarseCage coarseCage(const Version& version, size_t most, const WorkPart& part);

/// The quads that a surface is made of.
[[nodiscard]] QuadMesh quadsOf(const Surface& surface);

}  // namespace argil::clay
