#pragma once
// Formats that others read and write: plugins.

#include <filesystem>
#include <functional>
#include <string>
#include <string_view>
#include <vector>

#include "io/bytes/atomic_file.h"
#include "io/models/model_writer.h"

namespace argil::io {

struct AddedFormat {
  std::string name;       ///< For the user.
  std::string extension;  ///< Lower case with its dot; no other format has it, as it alone says what a file is.
  /// As readModel(), without the file's name in what it throws; empty: it is not read.
  std::function<ModelFile(const std::filesystem::path&, Job*)> read = {};
  /// Puts the model, which was checked, into the file; the caller commits. Empty: it is not written.
  std::function<void(AtomicFile&, const ModelView&, Job*)> write = {};
  /// Where each step of a history goes into a file of its own, NAME-0001 and so on: the ending of those. Empty: one
  /// file.
  std::string frameEnding = {};
};

/// From now on files of that ending are read and written by it, for the life of the program. Any thread. Throws Error:
/// another format has the ending, or there are too many.
void addFormat(AddedFormat format);
[[nodiscard]] bool hasFormat(std::string_view extension);
struct AddedFormatFacts {
  std::string_view name, extension;
  bool reads = false, writes = false, frames = false;
};
/// Those that were added so far. What its views are of stays.
[[nodiscard]] std::vector<AddedFormatFacts> addedFormats();
/// AddedFormat::frameEnding of the format with that ending; empty for others.
[[nodiscard]] std::string frameEndingOf(std::string_view extension);

}  // namespace argil::io
