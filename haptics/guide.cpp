#include "haptics/guide.h"

namespace argil::haptics {

void Guide::check() const {}

}  // namespace argil::haptics
