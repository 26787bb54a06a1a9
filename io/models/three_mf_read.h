#pragma once
// 3MF packages read. For this module's files.

#include "io/bytes/input.h"
#include "io/models/model_file.h"

namespace argil::io {

/// A ZIP archive that holds a 3MF model.
bool recognizesThreeMf(const Input& input);

/// Every mesh that the build places, as an object of its own: items, components in components, in other parts too
/// (production extension). Throws Error, Cancelled. Memory: the archive, its model parts unpacked one after another,
/// the meshes.
ModelFile parseThreeMf(const Input& input);

}  // namespace argil::io
