#pragma once
// The program's picture in task bars: a ball of clay with a groove.

#include "render/view/image.h"

namespace argil::studio {

/// Square, see-through around the ball; 16 to 512 pixels.
[[nodiscard]] render::Image icon(int pixels);

}  // namespace argil::studio
