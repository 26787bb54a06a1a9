#pragma once
// A cage of few quads around a clay.

#include "clay/base/work_part.h"
#include "clay/cage/quad_mesh.h"
#include "clay/store/version.h"

namespace argil::clay {

struct CoarseCage {
  QuadMesh mesh;
  double edgeMm = 0;  ///< About how long its edges are.
  /// Bodies less handles, counted with cavities, of the cage and of the clay: half of the Euler characteristic. Where
  /// they differ the cage has lost a part or closed a hole.
  int64_t shape = 0, clayShape = 0;
};

/// At most `most` quads, evenly sized and drawn onto the surface; closed, whatever the clay is. A grid that is shifted
/// between tries is looked through for one that has the clay's shape; where none has, the cage is the one that comes
/// nearest. Throws Error for empty clay and less than 24 quads, Cancelled. Cost: a few coarse resamplings.
[[nodiscard]] CoarseCage coarseCage(const Version& version, size_t most, const WorkPart& part);

}  // namespace argil::clay
