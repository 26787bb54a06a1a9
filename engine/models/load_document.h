#pragma once
// Any file that holds something to work on, as a document.

#include <filesystem>
#include <string>
#include <vector>

#include "clay/base/job.h"
#include "engine/document/document.h"
#include "engine/models/model_files.h"

namespace argil::engine {

struct LoadedDocument {
  DocumentPtr document;            ///< One piece at least, or one part.
  std::string what;                ///< "Argil document", "level set", "clay of a mesh".
  size_t steps = 0;                ///< Of history that the file keeps beside the document.
  std::vector<std::string> notes;  ///< Sentences for the person.
};

/// A saved document as it is, a level set as its clay, a mesh or model as `how` says. Throws Error that names the file;
/// Cancelled.
[[nodiscard]] LoadedDocument loadDocument(const std::filesystem::path& file, const ModelImport& how,
                                          Job* job = nullptr);

/// True for files that hold clay as it is: nothing has to be chosen to open them.
[[nodiscard]] bool holdsClay(const std::filesystem::path& file);

}  // namespace argil::engine
