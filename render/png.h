#pragma once
// PNG from memory.

#include <cstddef>
#include <span>

#include "render/image.h"

namespace argil::render {

/// Throws Error (input) for what is no PNG, is damaged, or has more than `mostEdge` pixels along a side.
[[nodiscard]] Image decodePng(std::span<const std::byte> bytes, int mostEdge = 1024);

}  // namespace argil::render
