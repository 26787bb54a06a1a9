#pragma once
// The kinds of files that the studio opens, imports and writes: rows of a table by their ending.

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace argil::studio {

struct FileKind {
  std::string_view ending;  ///< Small letters, with its dot.
  std::string_view name;    ///< "3MF".
  std::string_view units;   ///< What the format itself says of lengths; empty: nothing, so the person is asked.
  bool opens = false;       ///< As a document of its own.
  bool imports = false;     ///< Into the open document.
  std::string_view writes;  ///< What it is written for, a sentence; empty: it is not.
  bool reduces = false;     ///< Written as triangles, which can be made fewer.
};

/// Those of plugins too. The window's thread; made anew where a plugin has added some.
[[nodiscard]] std::span<const FileKind> fileKinds();
/// By the ending in any case; null: none of them.
[[nodiscard]] const FileKind* kindOf(const std::filesystem::path& file);
/// A model whose numbers could be millimetres as well as inches.
[[nodiscard]] bool asksForUnits(const std::filesystem::path& file);
[[nodiscard]] std::vector<std::string> endingsToOpen();
[[nodiscard]] std::vector<std::string> endingsToImport();
/// Images that a tool presses into the clay.
[[nodiscard]] std::vector<std::string> endingsOfImages();

}  // namespace argil::studio
