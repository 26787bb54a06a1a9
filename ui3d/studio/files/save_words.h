#pragma once
// Where the document is kept, in words.

#include <string>

#include "engine/session/workbench.h"
#include "ui3d/studio/files/when.h"

namespace argil::studio {

/// Returns the file's name, the name of what it was recovered from, or "Untitled".
[[nodiscard]] std::string documentName(const engine::FileState& file);
/// Of the window: "head.argil* — Argil", with a star while the file does not hold it; "Argil" while there is nothing.
[[nodiscard]] std::string windowTitle(const engine::FileState& file);

struct Keeping {
  std::string words;  ///< "Saved 12:31".
  bool ails = false;  ///< Neither the file nor the journal has it, or another window has the file too.
};
/// For the status line; `at` is now.
[[nodiscard]] Keeping savingWords(const engine::FileState& file, Moment at);

}  // namespace argil::studio
