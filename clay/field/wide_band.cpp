#include "clay/field/wide_band.h"

#include <openvdb/openvdb.h>
#include <openvdb/tools/FastSweeping.h>
#include <openvdb/tools/SignedFloodFill.h>

#include <cmath>

#include "clay/store/store.h"
#include "clay/store/vdb_bridge.h"

namespace argil::clay {

Version wideBand(const Version& version, float band, Job* job) {
  Grid grid = version.grid();
  // Rings of voxels: a diagonal step is worth at least one voxel.
  const int rings = static_cast<int>(std::ceil(band - grid.band)) + 1;
  const auto narrow = std::static_pointer_cast<openvdb::FloatGrid>(toVdb(version).grid);
  if (job && job->cancelled()) throw Cancelled();
  const openvdb::FloatGrid::Ptr wide = openvdb::tools::dilateSdf(*narrow, rings, openvdb::tools::NN_FACE_EDGE_VERTEX);
  if (job && job->cancelled()) throw Cancelled();
  openvdb::tools::changeBackground(wide->tree(), band);
  openvdb::tools::signedFloodFill(wide->tree());
  grid.band = band;
  return fromVdb(Store::make(), grid, {wide});
}

}  // namespace argil::clay
