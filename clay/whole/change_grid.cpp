#include "clay/whole/change_grid.h"

#include "clay/field/region_work.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"

namespace argil::clay {

Version scaled(const Version& version, double factor, const WorkPart& part) {
  Grid grid = version.grid();
  grid.voxelMm *= factor;
  grid.originMm *= factor;
  Editor editor(Version::empty(Store::make(version.store()->precision()), grid));
  copyAll(version, editor, part);
  return editor.commit();
}

}  // namespace argil::clay
