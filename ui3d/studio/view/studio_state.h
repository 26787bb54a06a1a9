#pragma once
// What the studio itself remembers: how things are looked at and what the person has in hand. The model is the
// workbench's.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "clay/whole/pegs.h"
#include "engine/document/document.h"
#include "engine/session/workbench.h"
#include "engine/tools/tool_table.h"
#include "haptics/scene/workspace.h"
#include "render/renderer/renderer.h"
#include "ui3d/studio/view/deform_box.h"
#include "ui3d/studio/view/drawn_curve.h"
#include "ui3d/studio/view/plane_cut.h"

namespace argil::studio {

enum class Theme : uint8_t { dark, light };
/// What the sizes of tools go with: nothing, the model that is worked on, or what is seen of it.
enum class SizeBy : uint8_t { millimetres, model, view };
enum class GizmoMode : uint8_t { none, move, rotate, scale };

/// Panels that can be shown and hidden.
struct PanelsShown {
  bool tools = true, settings = true, things = true, history = false, view = false, touch = false, quality = false,
       facts = false, print = false, messages = false, exporting = false, palette = false, firstStart = true,
       shortcuts = false, preferences = false, plugins = false;
};

/// What the window measured; shown in panels and written by --report.
struct FrameFigures {
  double frameMs = 0, framesPerSecond = 0;
  bool still = true;  ///< The full picture is shown, not the thinned one.
  uint64_t triangles = 0, uploadedBytes = 0, deviceBytes = 0;
  double sampleToScreenMs = 0;
  std::string deviceName;
  std::vector<render::PassTime> passes;
};

/// A picture for a file.
struct PictureWish {
  std::filesystem::path file;
  int longestPixels = 0;  ///< Of its longer edge; 0: as large as the window's.
};

/// What an action or a panel asks of another part of the studio. Who serves it empties it.
struct Wishes {
  std::string place;  ///< A kind of guide, to be placed by clicks: Widgets::place().
  /// Of the panels: "new", "open", "recent", "save", "saveAs", "saveCopy", "import", "part", "export", "picture",
  /// "recover", "clay", "toolFile"; "export.stl" names a format, "piece.join" a row of engine::pieceJobs().
  std::string dialog;
  std::optional<std::filesystem::path> open;  ///< This file as the document: a model is asked about.
  std::optional<std::filesystem::path> save;  ///< The document, to this file; empty: to its own.
  std::optional<std::filesystem::path> copy;  ///< The document without its history, to this file.
  std::optional<PictureWish> picture;
  bool quickRing = false;  ///< Around the cursor.
};

/// How models came in last: asked for again, this is what is offered.
struct ImportChoice {
  bool voxelGiven = false;  ///< Else 256 voxels along the longest side.
  double voxelMm = 0.5;
  bool halfMemory = false;  ///< Distances of 16 bits.
  friend bool operator==(const ImportChoice&, const ImportChoice&) = default;
};

/// How the clay is to be printed.
struct PrintChoice {
  int process = 0;  ///< Of engine::printProcesses().
  double wallMm = 1, gapMm = 0.5, outletMm = 2;
  bool shown = false;  ///< What is thinner is coloured.
  /// Taken out of a mould along x, y, z: 1 to 3, or along the pull with the least undercut: kBestPull; 0: not cast.
  int pull = 0;
  static constexpr int kBestPull = 4;
  double draftDegrees = 2;
  Vec3d bedMm{250, 210, 210};  ///< Width, depth and height of the printer, for the check and for nesting.
};

/// A piece that is shown as an operation would make it, before it has.
struct GrownPiece {
  engine::Id piece = 0;
  double mm = 0;                  ///< render::PieceLook::grownMm.
  Vec3d factors = Vec3d::Ones();  ///< Scaled along the world's axes about `aboutMm`, world.
  Vec3d aboutMm = Vec3d::Zero();
  clay::Version before = {};  ///< The clay of an operation at work.
  /// Drawn in place of the piece, mm of the piece; null: the piece itself is drawn.
  std::shared_ptr<const clay::TriangleMesh> shape = {};
  friend bool operator==(const GrownPiece&, const GrownPiece&) = default;
};

/// Pegs of a cut that is asked about, in the world: they stand on the side that the normal leaves and reach into the
/// other.
struct PegsShown {
  std::vector<clay::Peg> pegs;
  Vec3d normal = Vec3d::UnitZ();
  bool loose = false;  ///< They reach into both sides.
};

struct StudioState {
  // In hand
  std::string toolId = "carve";
  /// Settings of each tool by id, kept when another is taken.
  std::map<std::string, engine::Tool, std::less<>> tools;
  bool inverted = false, smoothing = false;  ///< Keys held: the opposite tool, or smooth, for the moment.
  /// How deep mouse and pen go under the surface, as a part of the tool's radius: 0 to 1. Carving needs some.
  double pointerDepthMm = 0.6;
  double penCurve = 0;            ///< Of all pens: engine::curvedPressure(), −1 to 1.
  SizeBy sizeBy = SizeBy::model;  ///< What the tools' sizes go with.
  double sizedForMm = kUsualMm;   ///< Size of that when the tools' sizes were set; > 0.
  engine::Id otherPiece = 0;      ///< Under the cursor, and not worked on; 0: none.
  engine::Id selected = 0;        ///< A thing of the document; widgets are shown for it. 0: none.
  /// Selected besides `selected`, in the order in which they were added. Holds as long as `selected` is `beside`:
  /// whoever selects another thing selects it alone.
  struct MoreSelected {
    engine::Id beside = 0;
    std::vector<engine::Id> ids;
  };
  MoreSelected alsoSelected;
  bool straight = false;  ///< A drag over the clay draws a straight line, worked along when the button comes up.
  GizmoMode gizmo = GizmoMode::none;
  bool snapWidgets = true;  ///< Dragged widgets snap to guides, surface and grid.

  engine::Workbench::Things
      copied;  ///< By Copy and Cut: values, which outlive the document that they were copied from.

  std::optional<DeformBox> deformBox;    ///< Around a piece that is being deformed.
  std::optional<GrownPiece> grown;       ///< Of the operation that is asked about, else of the one at work.
  std::optional<GrownPiece> growing;     ///< At work: until its piece's next surface comes.
  std::optional<PegsShown> pegs;         ///< Of the cut that is asked about.
  std::optional<GrownPiece> scaled;      ///< In the hand that scales it.
  std::optional<PlaneCut> planeCut;      ///< Along which a piece is about to be cut or mirrored.
  std::optional<DrawnCurve> drawnCurve;  ///< Over the picture: a drag with the left button draws it.

  // Looks
  render::Look look;
  render::Stereo stereo;
  render::Quality quality;
  clay::Grade surface = clay::Grade::crisp;  ///< Of all pieces as they are drawn.
  static constexpr int kLeastFrames = 5, kMostFrames = 240, kUsualFrames = 60;
  int framesPerSecond = kUsualFrames;      ///< At most, while something changes.
  std::optional<render::Section> section;  ///< Kept while it is switched off: look.section is what is shown.
  haptics::Workspace workspace;
  haptics::Quality touchQuality;
  bool showWorkspaceBox = false;
  PrintChoice print;
  bool bedShown = false;  ///< Of `print`, on the ground: while something is checked or laid on it.

  // Panels
  PanelsShown shown;
  std::string over;  ///< The folded panel that stands over the clay until it is folded again, by its id; empty: none.
  bool foldPanels = true;  ///< Panels are folded where they would leave the clay less than kClayPart of the window.
  bool startPage = true;   ///< It comes when the studio starts without a file.
  Theme theme = Theme::dark;
  /// Theme and background that the settings keep while `theme` was given for this start alone; none: they are kept as
  /// they are.
  struct KeptTheme {
    Theme theme = Theme::dark;
    bool lightBackground = false;
  };
  std::optional<KeptTheme> keptTheme;
  float interfaceScale = 0;                              ///< 0: as the display says; else 0.75 to 4.
  std::map<std::string, std::string, std::less<>> keys;  ///< Shortcuts that the person changed: action id → "Ctrl+Z".
  std::vector<std::string> recentFiles;                  ///< Newest first, absolute.
  std::string lastFolder;                                ///< Where a file was opened or saved last.
  ImportChoice imports;
  double undoGiB = 2;  ///< Memory that undo steps may take: 0 to 64; 0: no limit.
  [[nodiscard]] uint64_t undoBytes() const;

  FrameFigures figures;
  Wishes wishes;
  bool fullScreen = false;     ///< The window follows.
  bool offersRecovery = true;  ///< What crashed sessions left is offered as soon as it is known.
  bool quit = false;           ///< The person wants to leave: the panels ask about unsaved work.
  bool leave = false;          ///< And nothing stands in the way of it.

  /// Returns everything that is selected, `selected` first; empty: nothing.
  [[nodiscard]] std::vector<engine::Id> selection() const;
  [[nodiscard]] bool isSelected(engine::Id id) const;
  /// Adds a thing to the selection, or takes it out where it is in it.
  void toggleSelected(engine::Id id);

  /// The tool as it is in hand now, with the keys that are held. Adds the standard settings of a tool that was never
  /// taken.
  engine::Tool& tool();
  /// `pointer`: mouse or pen is in hand; the tip of a device rules the depth of a cut itself, so it cuts hard.
  engine::Tool effectiveTool(bool pointer = true);
  /// The tool of a row as the studio begins with it, as large as the others are.
  [[nodiscard]] engine::Tool newTool(const engine::ToolRow& row) const;
  /// All lengths of all tools go from sizedForMm to this: of a model its longest side, of a view its height.
  /// Nothing for what is no length.
  void sizeTools(double forMm);
  static constexpr double kUsualMm = 96;  ///< What the standard sizes are for: a radius of 5 mm is 10 % of half of it.

  static constexpr size_t kMostRecent = 12;
  /// To the front of recentFiles; its folder is lastFolder.
  void remember(const std::filesystem::path& file);
};

}  // namespace argil::studio
