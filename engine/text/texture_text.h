#pragma once
// A texture as a few words: what `argil feel --texture` takes.

#include <memory>
#include <string>
#include <vector>

#include "haptics/scene/texture.h"

namespace argil::engine {

/// `ridges:WAVELENGTH:AMPLITUDE[:X,Y,Z]` (the direction across them), `bumps:WAVELENGTH:AMPLITUDE`,
/// `grain:WAVELENGTH:AMPLITUDE[:OCTAVES]` or `image:FILE:MM_PER_PIXEL:AMPLITUDE`, lengths in mm
/// (haptics/scene/texture.h). Throws Error that says what is wrong with it.
[[nodiscard]] std::shared_ptr<const haptics::Texture> parseTexture(const std::string& text);

/// "0.5" or "1,2,3" as numbers, all finite; throws Error "WHAT: ..." for anything else or another count.
[[nodiscard]] std::vector<double> parseNumbers(const std::string& text, size_t count, const std::string& what);

}  // namespace argil::engine
