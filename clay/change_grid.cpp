#include "clay/change_grid.h"

#include "clay/editor.h"
#include "clay/region_work.h"
#include "clay/settle.h"
#include "clay/store.h"

namespace argil::clay {

Version scaled(const Version& version, double factor, const WorkPart& part) {
  constexpr uint64_t kStepEvery = 4096;  // bricks between two looks at the job
  Grid grid = version.grid();
  grid.voxelMm *= factor;
  grid.originMm *= factor;
  Editor editor(Version::empty(Store::make(version.store()->precision()), grid));
  copyTiles(version, editor);
  uint64_t done = 0;
  const auto all = static_cast<double>(version.stats().bricks + 1);
  version.forEachBrick([&](const Brick& brick) {
    if (done++ % kStepEvery == 0) part.step(0.9 * static_cast<double>(done) / all);
    BrickValues room;
    editor.setVoxels(brick.coord, brick.values(room));
  });
  keepChannels(editor, version);
  part.step(1);
  return editor.commit();
}

}  // namespace argil::clay
