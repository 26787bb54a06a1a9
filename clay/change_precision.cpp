#include "clay/change_precision.h"

#include "clay/editor.h"
#include "clay/region_work.h"
#include "clay/store.h"

namespace argil::clay {

Version withPrecision(const Version& version, Precision precision, const WorkPart& part) {
  if (version.store()->precision() == precision) return version;
  Editor editor(Version::empty(Store::make(precision), version.grid()));
  copyAll(version, editor, part);
  return editor.commit();
}

}  // namespace argil::clay
