#pragma once
// What the studio itself remembers: how things are looked at and what the person has in hand. The model is the workbench's.

#include <map>
#include <string>
#include <vector>

#include "engine/document.h"
#include "engine/tool_table.h"
#include "haptics/workspace.h"
#include "render/renderer.h"

namespace argil::studio {

enum class Theme : uint8_t { dark, light };
enum class GizmoMode : uint8_t { none, move, rotate, scale };

/// Panels that can be shown and hidden.
struct PanelsShown {
  bool tools = true, settings = true, things = true, history = false, view = false, touch = false, quality = false, facts = false,
       messages = false, exporting = false, palette = false, firstStart = true, shortcuts = false, preferences = false;
};

/// What the window measured; shown in panels and written by --report.
struct FrameFigures {
  double frameMs = 0, framesPerSecond = 0;
  bool still = true;                    ///< The full picture is shown, not the thinned one.
  uint64_t triangles = 0, uploadedBytes = 0, deviceBytes = 0;
  double sampleToScreenMs = 0;
  std::string deviceName;
  std::vector<render::PassTime> passes;
};

/// What an action or a panel asks of another part of the studio. Who serves it empties it.
struct Wishes {
  std::string place;    ///< A kind of guide, to be placed by clicks: Widgets::place().
  std::string dialog;   ///< Of the panels: "new", "open", "import", "part", "export", "clay"; "export.stl" names a format.
};

struct StudioState {
  // In hand
  std::string toolId = "carve";
  std::map<std::string, engine::Tool, std::less<>> tools;  ///< Settings of each tool by id, kept when another is taken.
  bool inverted = false, smoothing = false;  ///< Keys held: the opposite tool, or smooth, for the moment.
  double pointerDepthMm = 0.6;   ///< How deep mouse and pen go under the surface, as a part of the tool's radius: 0 to 1. Carving needs some.
  engine::Id selected = 0;       ///< A thing of the document; widgets are shown for it. 0: none.
  GizmoMode gizmo = GizmoMode::none;
  bool snapWidgets = true;       ///< Dragged widgets snap to guides, surface and grid.

  // Looks
  render::Look look;
  render::Stereo stereo;
  render::Quality quality;
  std::optional<render::Section> section;  ///< Kept while it is switched off: look.section is what is shown.
  haptics::Workspace workspace;
  haptics::Quality touchQuality;
  bool showWorkspaceBox = false;

  // Panels
  PanelsShown shown;
  Theme theme = Theme::dark;
  float interfaceScale = 0;      ///< 0: as the display says; else 0.75 to 4.
  std::map<std::string, std::string, std::less<>> keys;  ///< Shortcuts that the person changed: action id → "Ctrl+Z".
  std::vector<std::string> recentFiles;

  FrameFigures figures;
  Wishes wishes;
  bool fullScreen = false;       ///< The window follows.
  bool quit = false;             ///< The person wants to leave.

  /// The tool as it is in hand now, with the keys that are held. Adds the standard settings of a tool that was never taken.
  engine::Tool& tool();
  engine::Tool effectiveTool();
};

}  // namespace argil::studio
