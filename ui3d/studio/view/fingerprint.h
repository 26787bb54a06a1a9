#pragma once
// Whether a picture would be the same as the last one.

#include "render/renderer/renderer.h"

namespace argil::studio {

/// 64 bits over all that present() is given but the model: equal for equal pictures. Cost: one pass over the overlays.
[[nodiscard]] uint64_t fingerprint(const render::Shot& shot, const render::Quality& quality);
[[nodiscard]] uint64_t fingerprint(const render::UiFrame& panels);

}  // namespace argil::studio
