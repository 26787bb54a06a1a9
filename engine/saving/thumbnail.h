#pragma once
// The small picture in a saved document.

#include <cstddef>
#include <filesystem>
#include <vector>

namespace argil::engine {

/// PNG, as SaveExtras::thumbnail was; empty: it has none. Reads no clay. Throws Error when it is no document, or cannot
/// be read. Any thread.
[[nodiscard]] std::vector<std::byte> thumbnailOf(const std::filesystem::path& file);

}  // namespace argil::engine
