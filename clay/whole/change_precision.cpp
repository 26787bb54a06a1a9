#include "clay/whole/change_precision.h"

#include "clay/field/region_work.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"

namespace argil::clay {

Version withPrecision(const Version& version, Precision precision, const WorkPart& part) {
  if (version.store()->precision() == precision) return version;
  Editor editor(Version::empty(Store::make(precision), version.grid()));
  copyAll(version, editor, part);
  return editor.commit();
}

}  // namespace argil::clay
