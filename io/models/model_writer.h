#pragma once
// Models to files: several objects with names and colours, in mm.

#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "clay/base/job.h"
#include "io/models/mesh_writer.h"
#include "io/models/model_file.h"

namespace argil::io {

struct ModelView {
  std::span<const ModelObject> objects;  ///< mm.
  std::vector<std::pair<std::string, std::string>> metadata = {};
  uint32_t frame = 0, frames = 1;  ///< Of a history in many files: which one this is, and how many there are.
};

/// Writes a model, whole or not at all, as MeshWriter does; formats of one mesh (STL, OBJ, PLY, .drc) get all objects
/// as one and drop what they cannot say: PLY and OBJ keep a colour a vertex, STL none. Throws Error, Cancelled.
WriteReport writeModel(const std::filesystem::path& path, const ModelView& model, const WriteOptions& options = {},
                       Job* job = nullptr);

/// What the format of this path cannot say of the model, a sentence each for the person, before it is written. Throws
/// Error for an ending that is not supported.
[[nodiscard]] std::vector<std::string> lossesOf(const std::filesystem::path& path, const ModelView& model,
                                                const WriteOptions& options = {});

}  // namespace argil::io
