#pragma once
// What is visible of a document, in a picture.

#include "clay/surface/surface.h"
#include "engine/document/document.h"
#include "render/renderer/renderer.h"

namespace argil::cli {

/// Uploads pieces and parts to a renderer that holds none; colours only where they say which is which.
void showDocument(const engine::Document& document, clay::Grade grade, render::Renderer& renderer);

}  // namespace argil::cli
