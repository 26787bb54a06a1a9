#pragma once
// The tools that there are.

#include <span>
#include <string_view>

#include "engine/parameter.h"
#include "engine/tool.h"

namespace argil::engine {

/// A row of the table. Everything that a face shows of a tool comes from here, so a new tool is a new row.
struct ToolRow {
  std::string_view id, name, help;   ///< help: one line.
  std::string_view icon;             ///< Name of a drawing that a face may know; else it shows the name's first letters.
  std::string_view key;              ///< Suggested shortcut, such as "C".
  clay::Operation operation;
  std::string_view opposite;         ///< Id of the tool that the invert key gives.
  std::span<const Parameter<Tool>> parameters;
};

/// In the order in which people expect them.
[[nodiscard]] std::span<const ToolRow> toolTable();
/// Null for an unknown id.
[[nodiscard]] const ToolRow* findTool(std::string_view id);
/// A tool as the row begins with.
[[nodiscard]] Tool standardTool(const ToolRow& row);

}  // namespace argil::engine
