#pragma once
// Search words of the palette: what other programs call a command.

#include <span>
#include <string_view>

namespace argil::studio {

/// Words by which a row of actions() is found besides its name.
struct Synonyms {
  std::string_view id;     ///< Action::id.
  std::string_view words;  ///< Small letters, separated by blanks.
};

[[nodiscard]] std::span<const Synonyms> synonyms();
/// Returns the words of a row; empty where it has none.
[[nodiscard]] std::string_view synonymsOf(std::string_view id);

}  // namespace argil::studio
