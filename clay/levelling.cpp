#include "clay/brush_method.h"
#include "clay/error.h"

namespace argil::clay {

std::unique_ptr<DistanceMethod> makeLevelling(const StrokeContext&) { throw Error("that method is not there yet"); }

}  // namespace argil::clay
