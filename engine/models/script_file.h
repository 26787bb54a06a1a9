#pragma once
// A script from a file, with the files that it names.

#include <filesystem>

#include "engine/text/script.h"

namespace argil::engine {

/// The same from a file; a relative import becomes relative to the file's folder.
[[nodiscard]] Script readScript(const std::filesystem::path& path);

}  // namespace argil::engine
