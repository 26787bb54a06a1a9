#pragma once
// The tools that there are.

#include <span>
#include <string>
#include <string_view>

#include "engine/document/parameter.h"
#include "engine/document/tool.h"
#include "haptics/scene/scene.h"

namespace argil::engine {

/// The plugin that a tool came by.
struct ToolOrigin {
  std::string id, version;
  std::string checksum;  ///< Of its plugin.json, and of its library where it has one.
};

/// What a tool needs a file for.
enum class ToolFile : uint8_t { none, image, shape };

/// A row of the table. A tool is its operations: everything that faces, scripts and the documentation say of it comes
/// from here, so a new tool is a new row.
struct ToolRow {
  std::string_view id, name, help;  ///< help: one line.
  std::string_view icon;            ///< Name of a drawing that a face may know; else it shows the name's first letters.
  std::string_view key = {};        ///< Suggested shortcut, such as "C".
  std::string_view group;           ///< Rows of a group follow each other.
  std::span<const clay::Operation> operations;
  haptics::Work work = haptics::Work::rub;  ///< How it feels.
  std::string_view opposite = {};  ///< Id of the tool that the invert key gives; its own: Tool::inverted; empty: none.
  std::span<const Parameter<Tool>> parameters;
  bool limited = false;  ///< clay::Brush::limited.
  bool bead = false;     ///< clay::Brush::bead.
  bool dye = false;
  ToolFile file = ToolFile::none;
  clay::Falloff falloff = clay::Falloff::smooth;  ///< A standard tool's.
  clay::Tip tip = clay::Tip::ball;
  double strength = 1;
  bool adds = false;  ///< clay::Brush::adds.
  // Of a tool that was added (engine/tools/added_tools.h); Tool::own are its parameters.
  const clay::Formula* formula = nullptr;
  const clay::ExternalBrush* external = nullptr;
  const ToolOrigin* origin = nullptr;  ///< Null: of the program. Its id is empty where a script brought the tool along.
};

/// The last of each row's parameters are those that every tool has: how the hand drives it.
inline constexpr size_t kHeldParameters = 6;
[[nodiscard]] inline std::span<const Parameter<Tool>> ownParameters(const ToolRow& row) {
  return row.parameters.first(row.parameters.size() - kHeldParameters);
}
[[nodiscard]] inline std::span<const Parameter<Tool>> heldParameters(const ToolRow& row) {
  return row.parameters.last(kHeldParameters);
}

/// In the order in which people expect them, those of plugins (engine/tools/added_tools.h) behind. Any thread; what was
/// returned stays.
[[nodiscard]] std::span<const ToolRow> toolTable();
/// Null for an unknown id.
[[nodiscard]] const ToolRow* findTool(std::string_view id);
/// A tool as the row begins with.
[[nodiscard]] Tool standardTool(const ToolRow& row);
/// The same as scripts, documents and journals begin with: what they do not name of the pressure it does not rule.
[[nodiscard]] Tool scriptTool(const ToolRow& row);
/// Whether it takes off a soft layer where its row cuts the tip out (Tool::soft).
[[nodiscard]] bool cutsSoftly(const Tool& tool);
/// How the tool feels: as its row says, but a soft cut rubs. Throws as rowOf().
[[nodiscard]] haptics::Work workOf(const Tool& tool);
/// What a pen's pressure rules in a standard tool. `depth`: the face presses the tip less deep; the rest is of the tool
/// itself.
enum class PressureRules : uint8_t { depth, radius, strength };
[[nodiscard]] PressureRules pressureRules(const ToolRow& row);
/// Of a row, by its id; null: it has none.
[[nodiscard]] const Parameter<Tool>* findParameter(const ToolRow& row, std::string_view id);

/// The row of this tool. Throws Error for an id that there is none of.
[[nodiscard]] const ToolRow& rowOf(const Tool& tool);

/// The rows of the program alone.
[[nodiscard]] std::span<const ToolRow> ownTools();

/// A brush of clay of this voxel size. Throws Error for what is out of range or missing. `before`: what a morphing tool
/// goes back to.
[[nodiscard]] std::shared_ptr<const clay::Brush> brushOf(const Tool& tool, const clay::Grid& grid,
                                                         const clay::Version& before = {});

}  // namespace argil::engine
