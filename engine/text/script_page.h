#pragma once
// The page on scripts, docs/scripts.md, for users: made from the tables that scripts are read by.

#include <span>
#include <string>
#include <string_view>

namespace argil::engine {

/// A key of a script that no other table names.
struct ScriptField {
  std::string_view
      where;  ///< The object that has it: "script", "setup", "block", "sphere", "materials[]", "stroke", "radial".
  std::string_view key, values, help;
};
[[nodiscard]] std::span<const ScriptField> scriptFields();

/// Scripts that the page shows; each can be run as it is.
[[nodiscard]] std::span<const std::string_view> scriptExamples();

/// The page, as Markdown: every field, tool, operation, guide and property of a material with units and ranges.
[[nodiscard]] std::string scriptPage();

}  // namespace argil::engine
