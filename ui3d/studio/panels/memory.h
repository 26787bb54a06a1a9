#pragma once
// What panels remember from frame to frame, and the functions that draw them. For this folder's files.

#include <array>
#include <deque>
#include <filesystem>
#include <functional>
#include <future>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "engine/document/jobs.h"
#include "engine/models/import_place.h"
#include "engine/plugins/plugins.h"
#include "engine/print/check_paint.h"
#include "engine/print/pieces_meet.h"
#include "engine/print/print_check.h"
#include "engine/print/pull_check.h"
#include "engine/tools/piece_cost.h"
#include "haptics/devices/registry.h"
#include "render/view/image.h"
#include "ui3d/studio/files/file_kinds.h"
#include "ui3d/studio/files/new_clay.h"
#include "ui3d/studio/files/save_flow.h"
#include "ui3d/studio/kit/file_dialog.h"
#include "ui3d/studio/kit/kit.h"
#include "ui3d/studio/kit/layout.h"
#include "ui3d/studio/panels/actions.h"
#include "ui3d/studio/view/context.h"

namespace argil::studio {

struct Said {
  engine::Message message;
  double timeS = 0;
  bool dismissed = false;  ///< No longer over the picture; still in the list.
};

/// Clay of 16-bit distances.
inline constexpr const char* kHalfMemory = "Half the memory";
inline constexpr const char* kHalfMemoryHelp =
    "Distances of 16 bits in place of 32: exact to a ten-thousandth of a voxel, strokes a tenth slower.";

/// An operation on whole pieces that is about to be begun.
struct Operation {
  const engine::PieceJob* row = nullptr;  ///< Null: none.
  engine::PieceArguments arguments;
  int plane = 0, curve = 0, direction = 0;  ///< As they are listed.
  std::vector<engine::Id> costOf = {};      ///< The pieces for which a voxel size was proposed.
  bool turned = false;                      ///< The plane faces the other way.
  clay::Version measured;                   ///< The clay of which this is the middle, world mm.
  Vec3d middleMm = Vec3d::Zero();
  /// What it would take, of these arguments and this clay.
  struct Price {
    engine::PieceArguments arguments;
    std::vector<clay::Version> clay;
    engine::PieceCost cost;
    std::string problem;  ///< Empty, or why it cannot be.
  };
  std::optional<Price> price = {};
};

/// What the file dialog was opened for.
enum class FilesFor : uint8_t { none, open, import, folder, save, copy, picture, toolFile, locate };

struct ExportChoice {
  std::set<std::string, std::less<>> endings{".3mf"};
  int what = 0;    ///< 0 what is visible, 1 every piece, 2 the selected one.
  int reduce = 0;  ///< 0 no, 1 to a count, 2 within an error, 3 quads.
  double thousandTriangles = 200, errorMm = 0.05, quads = 4000;
  bool mirrored = false;     ///< Of quads.
  bool alongGuides = false;  ///< Of quads and faces.
  double maskDensity = 1;    ///< The same.
  int textures = 2;          ///< Pictures on quads: 0 none, then 1024, 2048, 4096 pixels.
  int smooth = 0;            ///< Faces for CAD: 0 to a count, 1 within an error.
  double faces = 500, smoothErrorMm = 0.05;
  int surface = 0;  ///< 0 fine, 1 draft.
  bool recentre = false, putBack = false, draco = false;
  std::string folder, name;
  std::string proposed;               ///< The name as it was proposed last,
  uint64_t of = 0;                    ///< for this document: FileState::opened.
  std::vector<std::string> existing;  ///< Files that would be written over: asked about.
};

/// A model that is looked at before it comes in; without a name: none.
struct AskedModel {
  std::filesystem::path file = {};
  bool asDocument = false;  ///< To be opened, not imported.
  bool asPart = false;
  bool guides = false;                           ///< Of its faces.
  int units = 0, up = 0;                         ///< As they are listed: guessed first.
  std::optional<double> heightMm = {};           ///< None: what the unit makes it.
  bool keepsPlace = false;                       ///< Where the file has it; else on the ground, beside what is there.
  bool more = false;                             ///< Voxels are shown.
  bool guessed = false;                          ///< The guess of `look` was taken.
  bool accepted = false;                         ///< Enter came before the file was read.
  std::shared_ptr<engine::ModelLook> look = {};  ///< Filled by `reading`.
  bool keepsWalls = false;                       ///< Voxels as fine as the thinnest wall.
  std::shared_ptr<engine::ModelDetails> details = {};     ///< Filled by `measuring`.
  std::unique_ptr<engine::BackgroundJob> reading = {};    ///< Null for a format that is not looked at.
  std::unique_ptr<engine::BackgroundJob> measuring = {};  ///< Begins when the file was read.
};

/// The page of plugins, while it is open.
struct PluginsPage {
  std::future<engine::Plugins> reading;
  std::optional<engine::Plugins> found;
  std::string problem;
  std::pair<std::string, bool> pressed;  ///< Id, and whether it is to be enabled.
};

/// What is known of the print of the active piece.
struct PrintPage {
  struct Result {
    std::optional<engine::PrintReport> report;
    std::optional<engine::PullReport> pull;  ///< Of what is cast; places as the piece lies.
    bool bestPull = false;                   ///< That pull was looked for.
    /// Pieces that it meets, by name; nothing where it is alone.
    std::optional<std::vector<std::pair<std::string, engine::PiecesMeet>>> meets;
    std::string problem;
  };
  clay::Version seen;  ///< The clay, and since when it is that.
  double seenAtS = 0;
  clay::Version version;  ///< What is looked at, or was.
  haptics::Pose pose;
  /// The other pieces that are seen: which clay, and where.
  std::vector<std::pair<const void*, haptics::Pose>> around;
  engine::PrintProcess process;
  std::optional<engine::DraftLimit> draft;
  std::shared_ptr<Result> result, shown;
  engine::PrintProcess shownOf;
  std::optional<Vec3d> bestPull;               ///< As it was found last.
  std::optional<engine::CheckLimits> told;     ///< What the workbench colours.
  std::unique_ptr<engine::BackgroundJob> job;  ///< Last: it fills the result.
};

/// The page at the start.
struct StartPage {
  bool wasEmpty = true;            ///< The document, in the frame before.
  int chosen = -1;                 ///< By keys, among its tiles; −1: none.
  bool moved = false;              ///< In the last frame, to another tile.
  std::vector<std::string> files;  ///< Whose pictures these are, empty where a file has none.
  std::shared_ptr<std::vector<render::Image>> pictures;
  bool sent = false;                               ///< Whoever has the renderer took them.
  std::unique_ptr<engine::BackgroundJob> reading;  ///< Last: it fills the pictures.
};

/// Places of the pegs of a cut that is asked about.
struct PegPreview {
  struct Result {
    clay::PegPlan plan;  ///< In the world.
    std::string problem;
  };
  clay::Version of;  ///< Of this clay, with
  engine::PieceArguments arguments;
  std::shared_ptr<Result> result;
  std::unique_ptr<engine::BackgroundJob> job;  ///< Last: it fills the result.
};

/// The clay that an offset inwards, which is asked about, leaves.
struct OffsetPreview {
  struct Result {
    std::shared_ptr<const clay::TriangleMesh> shape;  ///< mm of the piece.
    std::string problem;
  };
  clay::Version of;  ///< Of this clay, moved by
  double mm = 0;
  std::shared_ptr<const clay::TriangleMesh> shape;  ///< The last one that was worked out of this clay; null: none.
  std::shared_ptr<Result> result;
  std::unique_ptr<engine::BackgroundJob> job;  ///< Last: it fills the result.
};

struct Memory {
  Layout layout;
  engine::TouchState touch;
  std::vector<float> frameMs;  ///< The last two hundred or so.

  std::deque<Said> said;
  bool moves = false;     ///< Panels::moves().
  bool handOpen = false;  ///< What every tool has is shown.
  /// Unfolded: how clay feels, where there is no device; figures for developers in the panels.
  bool feelOpen = false, qualityOpen = false, factsOpen = false, touchOpen = false;

  int material = 0;                                ///< That is shown of a piece: 0 the piece's own.
  std::pair<engine::Id, size_t> materialOf{0, 0};  ///< Whose name is in the field.
  std::string materialName;
  bool materialTyping = false;

  engine::Id renaming = 0;
  bool renameBegun = false;
  std::string renameText;
  const void* middleOf = nullptr;  ///< The clay or the mesh that `middleMm` was measured of.
  Vec3d middleMm = Vec3d::Zero();
  size_t historyShown = SIZE_MAX;  ///< The step that was scrolled to last.

  std::string paletteTyped;
  int paletteChosen = 0;
  bool paletteOpen = false;

  std::string keyFilter, keyEdited, keyText, keyProblem;
  bool keyBegins = false;

  std::vector<haptics::FoundDevice> found;
  double foundAtS = -1e9;

  FileDialog files;
  FilesFor filesFor = FilesFor::none;
  bool newClayOpen = false;
  NewClay newClay;
  PluginsPage plugins;
  PrintPage print;
  std::future<engine::MachineSpeed> measuring;
  std::optional<engine::MachineSpeed> machine;
  Operation operation;
  std::map<std::string_view, engine::PieceArguments> operations;  ///< As they were begun last, by id.
  PegPreview pegs;
  OffsetPreview offset;
  ExportChoice exporting;
  bool importAsPart = false;
  AskedModel asked;
  /// Cancelled; not waited for, as a tree is built whole.
  std::vector<std::unique_ptr<engine::BackgroundJob>> ending;
  std::deque<std::filesystem::path> toBeAsked;  ///< Files that were dropped together: one after the other.
  int pictureSize = 0;                          ///< 0 the view's, 1 4K.
  bool recentOpen = false, recoverOpen = false;
  int recentMarked = 0;  ///< Row of the recent files that Enter opens.
  SaveFlow keep;
  uint64_t madeSeen = UINT64_MAX;  ///< Snapshot::madeCount of the thing that was selected last for being new.
  double releasedS = 0;            ///< When the hand ended the stroke that is in work.
  bool handCuts = false;
  bool menuWished = false;               ///< The first menu is to be opened.
  double strokeFromS = 0;                ///< Of the hand's path, what was left to be worked on then.
  uint64_t refusedSeen = 0;              ///< Saves that failed, of those for which another name was offered.
  bool recoverOffered = false;           ///< Once after the start.
  std::filesystem::path recoverDoubted;  ///< The journal whose "Discard" was pressed once.
  engine::Recoverable located;           ///< Of FilesFor::locate: whose saved file is looked for.
  StartPage start;
  float noticesHeight = 0;  ///< Of what stands at the foot of the picture, in the frame before.
};

// Helpers for all of them.

/// Where everything stands for the state of the moment.
[[nodiscard]] Layout layoutOf(const Context& context);

/// The action's button: runs it, is lit while it is checked, says name, help and key in its tooltip.
bool actionButton(Context& context, std::string_view id, std::string_view icon, float edge,
                  std::string_view letters = {});
void runAction(Context& context, std::string_view id);
/// "Wax: the stroke is being worked into the clay, 40 %…": of the hand's path of `fromS` seconds `leftS` are left.
[[nodiscard]] std::string strokeWords(std::string_view tool, double leftS, double fromS);
/// By the person or by a fault, until they are resumed.
[[nodiscard]] bool forcesStopped(const Memory& memory);
/// The thing's drawing: of a piece "block", of a part "sphere", of guides their kind.
[[nodiscard]] std::string_view iconOf(const engine::Document& document, engine::Id id);

// Docks.
void drawMenu(Context& context, Memory& memory);
void drawBar(Context& context, Memory& memory);
void drawTools(Context& context, Memory& memory);
/// How many buttons each group has.
[[nodiscard]] std::vector<int> toolGroups();
void drawRail(Context& context, Memory& memory);
void drawStatus(Context& context, Memory& memory);
/// Toasts and progress, over the picture.
void drawNotices(Context& context, Memory& memory);

// Panels: what is in them; their docks are begun.
void settingsPanel(Context& context, Memory& memory);
void deformSection(Context& context);      ///< While there is a deform box, instead of the tool's settings.
void planeCutSection(Context& context);    ///< While a plane to cut along is placed, instead of the tool's settings.
void drawnCurveSection(Context& context);  ///< While a curve is drawn, instead of the tool's settings.
void materialsSection(Context& context, Memory& memory, const engine::Piece& piece);
[[nodiscard]] bool laysMaterial(const Context& context);  ///< The tool in hand.
void maskButtons(Context& context);                       ///< What can be done with a mask as a whole.
void inspector(Context& context, Memory& memory);         ///< Of the selected thing, within settings.
/// Heads the rows of how clay feels, folded away while no force device is in use; true where they are to be drawn.
[[nodiscard]] bool feelHeading(const Context& context, Memory& memory);
void thingsPanel(Context& context, Memory& memory);
void historyPanel(Context& context, Memory& memory);
void viewPanel(Context& context, Memory& memory);
void touchPanel(Context& context, Memory& memory);
void qualityPanel(Context& context, Memory& memory);
void factsPanel(Context& context, Memory& memory);
void printPanel(Context& context, Memory& memory);
void followPrint(Context& context, Memory& memory);  ///< In every frame, whether the panel is seen or not.
void messagesPanel(Context& context, Memory& memory);

// Dialogs over everything; each looks itself whether it is open.
void drawPalette(Context& context, Memory& memory);
void drawShortcuts(Context& context, Memory& memory);
void drawPlugins(Context& context, Memory& memory);
void drawPreferences(Context& context, Memory& memory);
void drawFirstStart(Context& context, Memory& memory);
/// Pictures that the renderer needs, by the names that the page uses from now on; each once.
[[nodiscard]] std::vector<std::pair<uint32_t, const render::Image*>> takePictures(StartPage& page);
/// Puts the open document away for something else; asks first where work would be lost.
void depart(Context& context, Memory& memory, Departure departure);
/// Opens a file as the document; asks for its units first where it names none.
void beginDocument(Context& context, Memory& memory, const std::filesystem::path& file);
/// `why`: a sentence that says why another name is asked for; empty: nothing went wrong.
void openSaveAs(Context& context, Memory& memory, const std::string& why = {});
void drawSave(Context& context, Memory& memory);
void drawRecover(Context& context, Memory& memory);
void drawRecent(Context& context, Memory& memory);
/// Reads a model, to be asked about: unit, up axis, size.
void askModel(Memory& memory, const std::filesystem::path& file, bool asDocument, bool asPart);
void drawAsked(Context& context, Memory& memory);
void drawExport(Context& context, Memory& memory);
/// How fast this machine is: known from an earlier day, else measured beside the studio the first time that a cost is
/// shown. Until then as nobody measured it.
[[nodiscard]] engine::MachineSpeed speedOf(Memory& memory);
void drawNewClay(Context& context, Memory& memory);
void beginOperation(Context& context, Memory& memory, std::string_view id);
void drawOperation(Context& context, Memory& memory);
/// Shows where the pegs of the cut that is asked about would stand, within its dialog; why there are none, a sentence,
/// or nothing. `piece`: that is cut; null: nothing is asked about.
[[nodiscard]] std::string followPegs(Context& context, Memory& memory, const engine::Piece* piece);
/// Works out what an offset inwards, which is asked about, leaves of a piece, within its dialog: OffsetPreview::shape.
/// Why nothing is left, or nothing. `piece`: as for followPegs().
[[nodiscard]] std::string followOffset(Context& context, Memory& memory, const engine::Piece* piece);
void drawFiles(Context& context, Memory& memory);
/// Opens the dialog that StudioState::wishes names.
void serveWishes(Context& context, Memory& memory);

}  // namespace argil::studio
