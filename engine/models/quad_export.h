#pragma once
// Pieces as few quads with pictures on them, for games and renderers.

#include <filesystem>
#include <string>
#include <vector>

#include "engine/models/model_files.h"

namespace argil::engine {

/// The pieces that count as meshes of at most `what.quads` quads each, or more as in clay::flatQuads(), and with
/// `what.texturePixels` their normals, colours and heights as pictures of so many pixels a side. Sentences for the
/// person: how far each mesh lies off its clay, how it was unwrapped, what files there are. Files of .obj and .glb; all
/// or none. Throws Error, Cancelled.
[[nodiscard]] std::vector<std::string> writeQuads(const std::filesystem::path& file, const Document& document,
                                                  const ModelExport& what, Job* job = nullptr);

}  // namespace argil::engine
