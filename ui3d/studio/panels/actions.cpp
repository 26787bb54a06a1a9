#include "ui3d/studio/panels/actions.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <initializer_list>

#include "ui3d/studio/files/file_kinds.h"
#include "ui3d/studio/files/new_clay.h"
#include "ui3d/studio/kit/rows.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/panels/synonyms.h"
#include "ui3d/studio/panels/view_actions.h"
#include "ui3d/studio/view/chosen_quality.h"
#include "ui3d/studio/view/panel_table.h"
#include "ui3d/studio/widgets/guide_places.h"

namespace argil::studio {
namespace {

using Text = std::string_view;

constexpr double kRadiusStep = 1.15;  // Of a tool, for each press of a key.

const engine::Thing* selected(const Context& c) {
  return c.now.document->thing(c.state.selected);
}
bool hasSelected(const Context& c) {
  return selected(c) != nullptr;
}
// All that is selected and still there, the first first.
std::vector<engine::Id> selection(const Context& c) {
  std::vector<engine::Id> ids = c.state.selection();
  std::erase_if(ids, [&](engine::Id id) { return !c.now.document->thing(id); });
  return ids;
}
// "Head", or "3 things".
std::string namesOf(const Context& c, const std::vector<engine::Id>& ids) {
  if (ids.size() != 1) return std::to_string(ids.size()) + " things";
  return c.now.document->thing(ids[0])->name;
}
bool hasRecoverable(const Context& c) {
  const auto list = c.bench.recoverable();
  return list && !list->empty();
}
bool hasClay(const Context& c) {
  return !c.now.document->pieces.empty();
}

// Document

void addClay(Context& c, Text shape) {
  NewClay clay;
  clay.shape = shape == "sphere" ? 1 : 0;
  clay.fit(*c.now.document);
  clay.add(c.bench);
  c.state.shown.firstStart = false;
}
void openDialog(Context& c, Text dialog) {
  c.state.wishes.dialog = dialog;
}

void changeSelected(Context& c, const char* verb, void (*change)(engine::Thing&)) {
  const std::vector<engine::Id> ids = selection(c);
  if (ids.empty()) return;
  c.bench.edit(verb + (" " + namesOf(c, ids)), [ids, change](engine::Document& d) {
    for (const engine::Id id : ids)
      if (engine::Thing* t = d.thing(id)) change(*t);
  });
}
void hideSelected(Context& c, Text) {
  const engine::Thing* thing = selected(c);
  if (thing && thing->visible)
    changeSelected(c, "Hide", [](engine::Thing& t) { t.visible = false; });
  else
    changeSelected(c, "Show", [](engine::Thing& t) { t.visible = true; });
}
void lockSelected(Context& c, Text) {
  const engine::Thing* thing = selected(c);
  if (thing && !thing->locked)
    changeSelected(c, "Lock", [](engine::Thing& t) { t.locked = true; });
  else
    changeSelected(c, "Unlock", [](engine::Thing& t) { t.locked = false; });
}
void removeSelected(Context& c, Text) {
  const std::vector<engine::Id> ids = selection(c);
  if (ids.empty()) return;
  c.bench.edit("Delete " + namesOf(c, ids), [ids](engine::Document& d) {
    for (const engine::Id id : ids) d.remove(id);
  });
  c.state.selected = 0;
}

// Copies. What is copied is a value: it stays as it was then, also when its document is closed.
// What is selected, where it is still there; else the piece that is worked on.
const engine::Thing* actedOn(const Context& c) {
  const engine::Thing* thing = selected(c);
  return thing ? thing : c.now.document->thing(c.now.document->active);
}
std::vector<engine::Id> actedOnAll(const Context& c) {
  std::vector<engine::Id> ids = selection(c);
  if (ids.empty() && actedOn(c)) ids.push_back(actedOn(c)->id);
  return ids;
}
engine::Workbench::Things selectedThings(const Context& c) {
  const engine::Document& d = *c.now.document;
  engine::Workbench::Things things;
  for (const engine::Id id : actedOnAll(c)) {
    if (const engine::Piece* piece = d.piece(id)) things.pieces.push_back(*piece);
    if (const engine::Part* part = d.part(id)) things.parts.push_back(*part);
    if (const engine::Guide* guide = d.guide(id)) things.guides.push_back(*guide);
  }
  return things;
}
bool hasThing(const Context& c) {
  return actedOn(c) != nullptr;
}
void isolateSelected(Context& c, Text) {
  const std::vector<engine::Id> ids = actedOnAll(c);
  if (ids.empty()) return;
  c.bench.edit("Hide all but " + namesOf(c, ids), [ids](engine::Document& d) {
    const auto show = [&](engine::Thing& t) { t.visible = std::find(ids.begin(), ids.end(), t.id) != ids.end(); };
    for (auto& t : d.pieces) show(t);
    for (auto& t : d.parts) show(t);
    for (auto& t : d.guides) show(t);
  });
}
void duplicate(Context& c, Text) {
  c.bench.add("Duplicate", selectedThings(c));
}
void copy(Context& c, Text) {
  c.state.copied = selectedThings(c);
}
void cut(Context& c, Text) {
  const std::vector<engine::Id> ids = actedOnAll(c);
  if (ids.empty()) return;
  copy(c, {});
  c.bench.edit("Cut " + namesOf(c, ids), [ids](engine::Document& d) {
    for (const engine::Id id : ids) d.remove(id);
  });
  c.state.selected = 0;
}
void paste(Context& c, Text) {
  c.bench.add("Paste", c.state.copied);
}

void moveSelected(Context& c, int by) {
  const engine::Thing* thing = selected(c);
  if (!thing) return;
  c.bench.edit("Move " + thing->name + " in the list",
               [id = thing->id, by](engine::Document& d) { d.reorder(id, by); });
}
void showAll(Context& c, Text) {
  c.bench.edit("Show everything", [](engine::Document& d) {
    for (auto& t : d.pieces) t.visible = true;
    for (auto& t : d.parts) t.visible = true;
    for (auto& t : d.guides) t.visible = true;
  });
}

// The piece that a deform box would be put around.
const engine::Piece* deformable(const Context& c) {
  const engine::Piece* piece = c.now.document->piece(c.state.selected);
  if (!piece) piece = c.now.document->workedOn();
  return piece && !piece->locked && piece->version && piece->version.stats().bricks > 0 ? piece : nullptr;
}
void switchDeformBox(Context& c, Text) {
  if (c.state.deformBox) {
    c.state.deformBox->cancel = true;
  } else if (const engine::Piece* piece = deformable(c)) {
    c.state.deformBox = DeformBox::around(*piece);
    c.state.shown.settings = true;
    if (layoutOf(c).settingsFolded) c.state.over = "settings";
    // It is larger than the piece: all of its points are to be within reach, beside the panels.
    render::Box all;
    for (const Vec3d& point : c.state.deformBox->lattice.points()) all.add(piece->pose.apply(point));
    c.camera.focus(all, freeAspect(layoutOf(c).free, c.width, c.height));
  }
}
bool hasDeformBox(const Context& c) {
  return c.state.deformBox.has_value();
}

// Told apart at a glance, in the order in which they come.
constexpr std::array<std::array<float, 3>, 6> kMaterialColours{{{0.36f, 0.55f, 0.75f},
                                                                {0.55f, 0.70f, 0.38f},
                                                                {0.80f, 0.45f, 0.38f},
                                                                {0.62f, 0.50f, 0.74f},
                                                                {0.85f, 0.74f, 0.36f},
                                                                {0.40f, 0.66f, 0.63f}}};

const engine::Piece* operatedOn(const Context& c) {
  const engine::Piece* piece = c.now.document->piece(c.state.selected);
  return piece ? piece : c.now.document->piece(c.now.document->active);
}
bool hasFreePiece(const Context& c) {
  return operatedOn(c) && !operatedOn(c)->locked;
}

// Operations on whole pieces: those that need nothing but a piece are done at once, the others are asked about.

bool asks(const engine::PieceJob& job) {
  return job.pieces == 2 || job.takesPlane || job.takesCurve || !job.parameters.empty();
}
void operate(Context& c, Text id) {
  const engine::PieceJob* job = engine::findPieceJob(id);
  if (!job) return;
  // A curve is drawn over the picture, where none was picked up.
  const engine::Guide* guide = c.now.document->guide(c.state.selected);
  if (job->takesCurve && !(guide && guide->kind == engine::Guide::Kind::curve)) {
    beginDrawnCurve(c, *job);
    return;
  }
  if (placesPlane(*job)) {
    beginPlaneCut(c, *job);
    if (layoutOf(c).settingsFolded) c.state.over = "settings";
    return;
  }
  if (asks(*job)) {
    c.state.wishes.dialog = "piece." + std::string(id);
    return;
  }
  engine::PieceArguments arguments = engine::standardArguments(*job, *c.now.document);
  if (job->pieces == 1 && c.now.document->piece(c.state.selected)) arguments.pieces = {c.state.selected};
  c.bench.operate(std::string(id), arguments);
}
bool hasDrawnCurve(const Context& c) {
  return c.state.drawnCurve && c.state.drawnCurve->drawn() && c.state.drawnCurve->cuts();
}
bool hasOtherSide(const Context& c) {
  return hasDrawnCurve(c) || c.state.planeCut;
}
void keepOtherSide(Context& c, Text) {
  if (c.state.planeCut) return c.state.planeCut->keepOther();
  c.state.drawnCurve->arguments.change<engine::CutValues>().keep = c.state.drawnCurve->kept() > 0 ? -1 : 1;
}
bool hasTwoPieces(const Context& c) {
  return c.now.document->pieces.size() > 1;
}

bool hidesPart(const Context& c) {
  const engine::Piece* piece = operatedOn(c);
  return piece && piece->hideMasked;
}

// Of those that are asked for between two strokes.
constexpr std::array<std::pair<Text, const char*>, 6> kPieceKeys{{{"cut-curve", "Shift+C"},
                                                                  {"mask-lasso", "Shift+M"},
                                                                  {"mask-invert", "Ctrl+M"},
                                                                  {"mask-clear", "Alt+M"},
                                                                  {"mask-hide", "Shift+H"},
                                                                  {"mask-show", "Ctrl+H"}}};

void addPieceRows(std::vector<Action>& rows) {
  for (const engine::PieceJob& job : engine::pieceJobs()) {
    if (job.id == "lattice") continue;  // Its points are pulled: the deform box.
    const std::string id(job.id);
    const auto key =
        std::find_if(kPieceKeys.begin(), kPieceKeys.end(), [&](const auto& each) { return each.first == job.id; });
    rows.push_back({"piece." + id, std::string(job.name) + (asks(job) ? "…" : ""), std::string(job.help), "Piece",
                    key == kPieceKeys.end() ? "" : key->second, operate, id,
                    id == "mask-show" ? hidesPart
                    : job.makesNew()  ? nullptr
                    : job.takesAll    ? hasClay
                    : job.pieces == 1 ? hasClay
                                      : hasTwoPieces});
    if (id == "mask-hide") rows.back().checked = [](const Context& c, Text) { return hidesPart(c); };
  }
  rows.push_back({"draw.apply", "Cut along the drawn curve", "The side that is to go goes.", "Piece", "Enter",
                  [](Context& c, Text) { c.state.drawnCurve->apply = true; }, "", hasDrawnCurve});
  rows.push_back({"draw.side", "Keep the other side", "Of a drawn curve, or of a plane that is placed.", "Piece", "Tab",
                  keepOtherSide, "", hasOtherSide});
  rows.push_back({"draw.cancel", "Put the drawn curve away", "Nothing is cut.", "Piece", "",
                  [](Context& c, Text) { c.state.drawnCurve->cancel = true; }, "",
                  [](const Context& c) { return c.state.drawnCurve.has_value(); }});
}

// Tools

void takeTool(Context& c, Text id) {
  c.state.toolId = id;
  if (c.state.drawnCurve) c.state.drawnCurve->cancel = true;  // The hand wants to work.
  if (c.state.planeCut) c.state.planeCut->cancel = true;
}
bool isTool(const Context& c, Text id) {
  return c.state.toolId == id;
}
void scaleRadius(Context& c, double factor) {
  const engine::ToolRow* row = engine::findTool(c.state.toolId);
  if (!row) return;
  for (const auto& parameter : row->parameters) {
    if (parameter.id == "radius") parameter.change(c.state.tool(), parameter.get(c.state.tool()) * factor);
  }
}
void takeOpposite(Context& c, Text) {
  const engine::ToolRow* row = engine::findTool(c.state.toolId);
  if (!row) return;
  if (row->opposite == row->id)
    c.state.tool().inverted = !c.state.tool().inverted;
  else
    c.state.toolId = row->opposite;
}
bool hasOpposite(const Context& c) {
  const engine::ToolRow* row = engine::findTool(c.state.toolId);
  return row && !row->opposite.empty();
}

bool engine::Symmetry::*planeOf(Text axis) {
  return axis == "x" ? &engine::Symmetry::x : axis == "y" ? &engine::Symmetry::y : &engine::Symmetry::z;
}
void switchSymmetry(Context& c, Text axis) {
  const auto plane = planeOf(axis);
  const bool on = !(c.now.document->symmetry.*plane);
  c.bench.setSymmetry([plane, on](engine::Symmetry& symmetry) { symmetry.*plane = on; });
}
void turnMore(Context& c, int by) {
  c.bench.setSymmetry(
      [by](engine::Symmetry& symmetry) { symmetry.turns = std::clamp(symmetry.turns + by, 1, engine::kMostTurns); });
}
bool isSymmetric(const Context& c, Text axis) {
  return c.now.document->symmetry.*planeOf(axis);
}

void useQuality(Context& c, Text id) {
  const engine::QualityPreset& preset = *engine::findQualityPreset(id);
  c.bench.setQuality(preset.quality.strokes);
  c.bench.setTouchQuality(c.state.touchQuality = preset.quality.touch);
  c.bench.setSurface(c.state.surface = preset.quality.surface);
  c.state.quality = pictureOf(id);
}

// A curve or a line; else null.
const engine::Guide* selectedWay(const Context& c) {
  const engine::Guide* guide = c.now.document->guide(c.state.selected);
  if (!guide) return nullptr;
  return guide->kind == engine::Guide::Kind::line ||
                 (guide->kind == engine::Guide::Kind::curve && guide->pointsMm.size() >= 2)
             ? guide
             : nullptr;
}
void strokeAlongSelected(Context& c, Text) {
  if (const engine::Guide* guide = selectedWay(c)) c.bench.strokeAlong(placesAlong(*guide));
}

void setGizmo(Context& c, Text mode) {
  const GizmoMode wanted = mode == "move" ? GizmoMode::move : mode == "rotate" ? GizmoMode::rotate : GizmoMode::scale;
  c.state.gizmo = c.state.gizmo == wanted ? GizmoMode::none : wanted;
  // Handles stand on what is selected: where nothing is, on the piece that is worked on.
  if (c.state.gizmo != GizmoMode::none && c.state.selection().empty()) c.state.selected = c.now.document->active;
}
bool isGizmo(const Context& c, Text mode) {
  return c.state.gizmo == (mode == "move" ? GizmoMode::move : mode == "rotate" ? GizmoMode::rotate : GizmoMode::scale);
}

// Panels

void switchPanel(Context& c, Text id) {
  if (const PanelRow* row = findPanel(id)) turnPanel(layoutOf(c), c.state, *row);
}
bool isPanel(const Context& c, Text id) {
  const PanelRow* row = findPanel(id);
  return row && isSeen(layoutOf(c), c.state, *row);
}
void setTheme(Context& c, Text id) {
  c.state.theme = id == "dark"                   ? Theme::dark
                  : id == "light"                ? Theme::light
                  : c.state.theme == Theme::dark ? Theme::light
                                                 : Theme::dark;
  c.state.keptTheme.reset();  // Chosen by hand, so kept.
  c.state.look.lightBackground = c.state.theme == Theme::light;
}

void addDocumentRows(std::vector<Action>& rows) {
  rows.push_back({"file.new", "New", "An empty document.", "File", "Ctrl+N", openDialog, "new"});
  rows.push_back({"file.open", "Open…", "A saved document, a script or a model as the document.", "File", "Ctrl+O",
                  openDialog, "open"});
  rows.push_back(
      {"file.recent", "Open recent…", "What was opened or saved last.", "File", "Ctrl+Shift+O", openDialog, "recent"});
  rows.push_back({"file.recover", "Recover…", "What was not saved when Argil ended without asking.", "File", "",
                  openDialog, "recover", hasRecoverable});
  rows.push_back(
      {"file.save", "Save", "The document with its history, to its file.", "File", "Ctrl+S", openDialog, "save"});
  rows.push_back({"file.saveAs", "Save as…", "The document to another file, with which work goes on.", "File",
                  "Ctrl+Shift+S", openDialog, "saveAs"});
  rows.push_back({"file.saveCopy", "Save a copy without history…",
                  "The document alone, to be given away: nothing that was taken out or undone is in it.", "File", "",
                  openDialog, "saveCopy"});
  rows.push_back({"file.import", "Import as clay…", "A model becomes a piece of clay of this document.", "File",
                  "Ctrl+I", openDialog, "import"});
  rows.push_back({"file.part", "Import as part…", "A model that is seen and felt, but not clay.", "File",
                  "Ctrl+Shift+I", openDialog, "part"});
  rows.push_back({"file.export", "Export…", "Writes the clay for printers and other programs.", "File", "Ctrl+E",
                  openDialog, "export", hasClay});
  for (const FileKind& kind : fileKinds()) {
    if (kind.writes.empty()) continue;
    rows.push_back({"file.export" + std::string(kind.ending), "Export " + std::string(kind.name) + "…",
                    std::string(kind.writes), "File", "", openDialog, "export" + std::string(kind.ending), hasClay});
  }
  rows.push_back({"file.picture", "Save picture…", "The view as a PNG, at full quality and without panels.", "File",
                  "Ctrl+Shift+P", openDialog, "picture"});
  rows.push_back(
      {"file.quit", "Quit", "Leaves Argil.", "File", "Ctrl+Q", [](Context& c, Text) { c.state.quit = true; }});

  rows.push_back({"edit.undo", "Undo", "One step back.", "Edit", "Ctrl+Z", [](Context& c, Text) { c.bench.undo(); }, "",
                  [](const Context& c) { return c.now.done > 0; }});
  rows.push_back({"edit.redo", "Redo", "One step forward.", "Edit", "Ctrl+Shift+Z Ctrl+Y",
                  [](Context& c, Text) { c.bench.redo(); }, "",
                  [](const Context& c) { return c.now.history && c.now.done < c.now.history->size(); }});
  rows.push_back({"edit.duplicate", "Duplicate", "A copy of what is selected, beside what is there.", "Edit",
                  "Ctrl+D Shift+D", duplicate, "", hasThing});
  rows.push_back({"edit.cut", "Cut", "Takes what is selected out, to be pasted here or in another document.", "Edit",
                  "Ctrl+X", cut, "", hasThing});
  rows.push_back({"edit.copy", "Copy", "Remembers what is selected, to be pasted here or in another document.", "Edit",
                  "Ctrl+C", copy, "", hasThing});
  rows.push_back({"edit.paste", "Paste", "Puts what was copied beside what is there.", "Edit", "Ctrl+V", paste, "",
                  [](const Context& c) { return !c.state.copied.empty(); }});
  rows.push_back({"edit.hide", "Hide or show selected", "Hidden things are not felt either.", "Edit", "H", hideSelected,
                  "", hasSelected});
  rows.push_back({"edit.showAll", "Show everything", "Shows all that was hidden.", "Edit", "Alt+H", showAll});
  rows.push_back({"edit.isolate", "Hide all others",
                  "Shows what is selected alone; Show everything brings the rest back.", "Edit", "", isolateSelected,
                  "", hasThing});
  rows.push_back({"edit.lock", "Lock or unlock selected", "Locked things are neither edited nor moved.", "Edit", "L",
                  lockSelected, "", hasSelected});
  rows.push_back({"edit.moveUp", "Move up in the list", "Of two guides that contradict each other the upper one holds.",
                  "Edit", "Alt+Up", [](Context& c, Text) { moveSelected(c, -1); }, "", hasSelected});
  rows.push_back({"edit.moveDown", "Move down in the list", "Below the next of its kind.", "Edit", "Alt+Down",
                  [](Context& c, Text) { moveSelected(c, 1); }, "", hasSelected});
  rows.push_back(
      {"edit.delete", "Delete selected", "Undo brings it back.", "Edit", "Delete", removeSelected, "", hasSelected});
  rows.push_back({"edit.selectNone", "Select nothing", "Puts the widgets away.", "Edit", "",
                  [](Context& c, Text) { c.state.selected = 0; }, "", hasSelected});

  rows.push_back({"clay.block", "Add a block", "A block of clay: 60 × 60 × 40 mm, or as large as what is there.",
                  "Clay", "", addClay, "block"});
  rows.push_back({"clay.sphere", "Add a ball", "A ball of clay: 60 mm across, or as large as what is there.", "Clay",
                  "", addClay, "sphere"});
  rows.push_back({"clay.deformBox", "Deform box", "Points around a piece that pull its clay; bend, twist and taper.",
                  "Clay", "", switchDeformBox, "",
                  [](const Context& c) { return hasDeformBox(c) || (deformable(c) && !c.now.inStroke); },
                  [](const Context& c, Text) { return hasDeformBox(c); }});
  rows.push_back({"clay.deformApply", "Apply the deform box", "Keeps the clay as the box has made it.", "Clay", "",
                  [](Context& c, Text) { c.state.deformBox->apply = true; }, "", hasDeformBox});
  rows.push_back({"clay.deformCancel", "Cancel the deform box", "The clay as it was before.", "Clay", "",
                  [](Context& c, Text) { c.state.deformBox->cancel = true; }, "", hasDeformBox});
  rows.push_back({"clay.materials", "Materials", "Names, colours and feel of what a piece is made of.", "Clay", "",
                  [](Context& c, Text) {
                    c.state.selected = operatedOn(c)->id;
                    c.state.shown.settings = true;
                  },
                  "", [](const Context& c) { return operatedOn(c) != nullptr; }});
  rows.push_back({"clay.materialAdd", "Add a material", "What the material tool can lay.", "Clay", "",
                  [](Context& c, Text) { addMaterial(c, *operatedOn(c)); }, "", hasFreePiece});
  rows.push_back(
      {"clay.add", "Add clay…", "A block or a ball of the size that is wanted.", "Clay", "", openDialog, "clay"});
}

void addHandRows(std::vector<Action>& rows) {
  for (const engine::ToolRow& tool : engine::toolTable()) {
    rows.push_back({"tool." + std::string(tool.id), std::string(tool.name), std::string(tool.help), "Tool",
                    std::string(tool.key), takeTool, std::string(tool.id), nullptr, isTool});
  }
  rows.push_back({"tool.smaller", "Smaller tool", "By an eighth; also F and a drag.", "Tool", "[",
                  [](Context& c, Text) { scaleRadius(c, 1 / kRadiusStep); }});
  rows.push_back({"tool.larger", "Larger tool", "By an eighth; also F and a drag.", "Tool", "]",
                  [](Context& c, Text) { scaleRadius(c, kRadiusStep); }});
  rows.push_back({"tool.opposite", "Opposite tool", "Add for carve, carve for add; Ctrl held does it for a stroke.",
                  "Tool", "I", takeOpposite, "", hasOpposite});
  rows.push_back({"tool.straight", "Straight lines",
                  "A drag over the clay draws a straight line, which is worked along when the button comes up.", "Tool",
                  "D", [](Context& c, Text) { c.state.straight = !c.state.straight; }, "", nullptr,
                  [](const Context& c, Text) { return c.state.straight; }});
  struct Plane {
    const char *axis, *name, *help, *key;
  };
  for (const Plane& p : {Plane{"x", "Symmetry X", "Strokes are repeated as mirror images along X.", "X"},
                         Plane{"y", "Symmetry Y", "Strokes are repeated as mirror images along Y.", "Y"},
                         Plane{"z", "Symmetry Z", "Strokes are repeated as mirror images along Z.", "Z"}})
    rows.push_back({std::string("symmetry.") + p.axis, p.name, p.help, "Tool", p.key, switchSymmetry, p.axis, nullptr,
                    isSymmetric});
  rows.push_back({"symmetry.more", "Symmetry around z: one more", "Strokes are repeated around the z axis.", "Tool", "",
                  [](Context& c, Text) { turnMore(c, 1); }});
  rows.push_back({"symmetry.fewer", "Symmetry around z: one fewer", "Down to none.", "Tool", "",
                  [](Context& c, Text) { turnMore(c, -1); }, "",
                  [](const Context& c) { return c.now.document->symmetry.turns > 1; }});

  for (const engine::QualityPreset& preset : engine::qualityPresets())
    rows.push_back({"quality." + std::string(preset.id), std::string(preset.name) + " quality",
                    std::string(preset.help), "View", "", useQuality, std::string(preset.id), nullptr,
                    [](const Context& c, Text id) { return isChosen(id, c.state, *c.now.document); }});

  struct Row {
    const char *kind, *name, *help;
  };
  for (const Row& row : {Row{"plane", "Add a plane", "A plane to snap to, by eye and by touch."},
                         Row{"line", "Add a line", "Between two clicks."}, Row{"point", "Add a point", "At a click."},
                         Row{"curve", "Add a curve", "Through clicks on the clay; Enter ends it."},
                         Row{"box", "Add a keep-out box", "The tool may not enter it."},
                         Row{"ruler", "Add a ruler", "The distance of two clicks."},
                         Row{"angle", "Add an angle", "The angle of three clicks."},
                         Row{"thickness", "Measure the thickness",
                             "Reads how thick the clay is under the pointer, in mm; a click keeps the reading."}}) {
    rows.push_back({std::string("guides.") + row.kind, row.name, row.help, "Guides", "",
                    [](Context& c, Text kind) { c.state.wishes.place = kind; }, row.kind});
  }
  rows.push_back({"guides.stroke", "Stroke along it", "The tool in hand goes along the selected curve or line.",
                  "Guides", "", strokeAlongSelected, "",
                  [](const Context& c) { return selectedWay(c) && c.now.document->workedOn() && !c.now.inStroke; }});
  struct Mode {
    const char *mode, *name, *key, *help;
  };
  for (const Mode& m :
       {Mode{"move", "Move selected", "G", "Handles on the selected thing."},
        Mode{"rotate", "Rotate selected", "R", "Handles on the selected thing."},
        Mode{"scale", "Scale selected", "T",
             "A box around the selected thing: a side stretches one axis, a corner and the ring all. Ctrl: about the "
             "middle."}}) {
    rows.push_back(
        {std::string("gizmo.") + m.mode, m.name, m.help, "Guides", m.key, setGizmo, m.mode, nullptr, isGizmo});
  }
  rows.push_back({"guides.snap", "Snap", "Dragged widgets snap to guides, clay and grid.", "Guides", "N",
                  [](Context& c, Text) { c.state.snapWidgets = !c.state.snapWidgets; }, "", nullptr,
                  [](const Context& c, Text) { return c.state.snapWidgets; }});
}

void addTouchRows(std::vector<Action>& rows) {
  rows.push_back({"touch.stop", "Stop forces", "Zero force at once, until they are resumed.", "Touch", "Ctrl+.",
                  [](Context& c, Text) { c.bench.stopForces(); }});
  rows.push_back({"touch.resume", "Resume forces", "Forces begin anew, from zero.", "Touch", "Ctrl+Shift+.",
                  [](Context& c, Text) { c.bench.resumeForces(); }});
  rows.push_back({"touch.pointer", "Use mouse or pen", "Works without a force device.", "Touch", "",
                  [](Context& c, Text) { c.bench.useDevice("pointer"); }});
  rows.push_back({"touch.workspaceBox", "Show the device's reach", "The box that the hand can reach.", "Touch", "",
                  [](Context& c, Text) { c.state.showWorkspaceBox = !c.state.showWorkspaceBox; }, "", nullptr,
                  [](const Context& c, Text) { return c.state.showWorkspaceBox; }});
}

void addWindowRows(std::vector<Action>& rows) {
  for (const PanelRow& panel : panelTable()) {
    const bool help = panel.id == "shortcuts" || panel.id == "firstStart" || panel.id == "plugins";
    rows.push_back({"panel." + std::string(panel.id), std::string(panel.name), std::string(panel.help),
                    help ? "Help" : "Window", std::string(panel.shortcut), switchPanel, std::string(panel.id), nullptr,
                    isPanel});
  }
  rows.push_back({"window.theme", "Light or dark", "Changes the theme.", "Window", "", setTheme});
  rows.push_back({"window.fullScreen", "Full screen", "The window alone on the screen.", "Window", "F11",
                  [](Context& c, Text) { c.state.fullScreen = !c.state.fullScreen; }, "", nullptr,
                  [](const Context& c, Text) { return c.state.fullScreen; }});
}

// How well one typed word is met by a text: 0: not at all. Letters in order; beginnings of words and letters that
// follow each other count more. 1 where some letter is neither: what somebody else calls so comes first.
int match(Text typed, Text text) {
  int score = 1;
  size_t at = 0;
  bool following = false, scattered = false;
  for (const char letter : typed) {
    const auto wanted = std::tolower(static_cast<unsigned char>(letter));
    size_t best = Text::npos;
    for (size_t i = at; i < text.size(); ++i) {
      if (std::tolower(static_cast<unsigned char>(text[i])) != wanted) continue;
      if (best == Text::npos) best = i;
      const bool begins = i == 0 || text[i - 1] == ' ';
      if ((following && i == at) || begins) {
        best = i;
        break;
      }
    }
    if (best == Text::npos) return 0;
    const bool begins = best == 0 || text[best - 1] == ' ';
    score += (begins ? 8 : 0) + (following && best == at ? 6 : 0) + (best == 0 ? 4 : 0);
    scattered |= !begins && !(following && best == at);
    at = best + 1;
    following = true;
  }
  return scattered ? 1 : score;
}

char small(char letter) {
  return static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
}

// Calls `what` with each word of a text.
template <class What>
void eachWord(Text text, const What& what) {
  for (size_t begin = 0; begin < text.size();) {
    const size_t end = std::min(text.find(' ', begin), text.size());
    if (end > begin) what(text.substr(begin, end - begin));
    begin = end + 1;
  }
}

bool same(Text a, Text b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) { return small(x) == small(y); });
}
bool isOneOf(Text word, std::initializer_list<Text> words) {
  return std::any_of(words.begin(), words.end(), [&](Text each) { return same(word, each); });
}

bool hasWord(Text name, Text typed) {
  bool whole = false;
  eachWord(name, [&](Text word) { whole |= same(typed, word); });
  return whole;
}

// How well a name is met: from whichever word on that is best, by a whole word of it twice as well as by its letters.
int matchName(Text typed, Text name) {
  constexpr int kFirst = 4;  // The share of a text's first letter in what match() gives.
  int best = match(typed, name);
  for (size_t at = name.find(' '); at != Text::npos; at = name.find(' ', at + 1))
    best = std::max(best, match(typed, name.substr(at + 1)) - kFirst);
  return (hasWord(name, typed) ? 2 : 1) * best;
}

// How well a typed word is met by one of the synonyms: by a whole one half as well as by a name, by a beginning a
// quarter.
int matchSynonym(Text typed, Text synonyms) {
  constexpr size_t kLeast = 2;  // Letters of a beginning.
  int best = 0;
  eachWord(synonyms, [&](Text word) {
    if (typed.size() > word.size() ||
        !std::equal(typed.begin(), typed.end(), word.begin(), [](char a, char b) { return small(a) == b; }))
      return;
    if (typed.size() == word.size())
      best = std::max(best, 2 * match(typed, word));
    else if (typed.size() >= kLeast)
      best = std::max(best, match(typed, word));
  });
  return best;
}

// Letters that have to be typed, left out, changed or swapped with their neighbour to make one word of the other.
size_t editDistance(Text a, Text b) {
  std::vector<std::vector<size_t>> way(a.size() + 1, std::vector<size_t>(b.size() + 1));
  for (size_t i = 0; i <= a.size(); ++i) {
    for (size_t j = 0; j <= b.size(); ++j) {
      if (i == 0 || j == 0) {
        way[i][j] = i + j;
        continue;
      }
      const auto same = [&](size_t x, size_t y) { return small(a[x]) == small(b[y]); };
      way[i][j] = std::min({way[i - 1][j] + 1, way[i][j - 1] + 1, way[i - 1][j - 1] + (same(i - 1, j - 1) ? 0 : 1)});
      if (i > 1 && j > 1 && same(i - 1, j - 2) && same(i - 2, j - 1))
        way[i][j] = std::min(way[i][j], way[i - 2][j - 2] + 1);
    }
  }
  return way[a.size()][b.size()];
}

// The least of it to a word of the text or to a beginning of one, in parts of the typed word's length.
double strangeness(Text typed, Text text) {
  double least = HUGE_VAL;
  eachWord(text, [&](Text word) {
    for (size_t length = typed.size() - std::min(typed.size(), size_t{1}); length <= typed.size() + 1; ++length)
      least = std::min(least, double(editDistance(typed, word.substr(0, length))));
    least = std::min(least, double(editDistance(typed, word)));
  });
  return least / double(std::max(typed.size(), size_t{1}));
}

}  // namespace

void addMaterial(Context& context, const engine::Piece& piece) {
  context.bench.edit("Add a material", [id = piece.id](engine::Document& d) {
    engine::Piece* each = d.piece(id);
    if (!each || each->materials.size() >= engine::kMaxMaterialRows) return;
    engine::MaterialRow row;
    row.name = "Material " + std::to_string(each->materials.size() + 1);
    row.material = each->material;
    row.colour = kMaterialColours[each->materials.size() % kMaterialColours.size()];
    each->materials.push_back(std::move(row));
  });
}

const std::vector<Action>& actions() {
  static std::vector<Action> table;
  static size_t tools = 0;
  if (const size_t now = engine::toolTable().size(); table.empty() || now != tools) {
    tools = now;
    table.clear();
    addDocumentRows(table);
    addHandRows(table);
    addPieceRows(table);
    addViewRows(table);
    addTouchRows(table);
    addWindowRows(table);
    for (Action& action : table) action.synonyms = synonymsOf(action.id);
  }
  return table;
}

const Action* findAction(std::string_view id) {
  const auto& rows = actions();
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const Action& each) { return each.id == id; });
  return row == rows.end() ? nullptr : &*row;
}

std::vector<const Action*> searchActions(std::string_view typed) {
  const bool several = typed.find(' ') != Text::npos;
  std::vector<std::pair<double, const Action*>> found;
  for (const Action& action : actions()) {
    double score = 1;  // Of many words: a product that no integer holds.
    for (size_t begin = 0; begin < typed.size();) {
      const size_t end = std::min(typed.find(' ', begin), typed.size());
      if (const Text word = typed.substr(begin, end - begin);
          several && isOneOf(word, {"a", "the", "to", "of", "by", "and"})) {
        // Asked for by nobody, but part of some names.
        if (hasWord(action.name, word)) score *= 4 * matchName(word, action.name);
      } else if (!word.empty()) {
        // A name counts four times a group; help counts only for a word that stands in it as it was typed.
        const int inHelp = word.size() >= 3 && Text(action.help).find(word) != Text::npos ? 2 : 0;
        // "Move brush" asks for a tool.
        const int kind = several && isOneOf(word, {"brush", "tool"}) ? (action.id.starts_with("tool.") ? 100 : 1) : 0;
        const int best = std::max({4 * matchName(word, action.name), match(word, action.group),
                                   matchSynonym(word, action.synonyms), inHelp, kind});
        score = best == 0 ? 0 : score * best;
        if (score == 0) break;
      }
      begin = end + 1;
    }
    if (!typed.empty() && same(typed, action.name)) score = HUGE_VAL;  // Its whole name.
    if (score > 0) found.emplace_back(score, &action);
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first > b.first; });
  std::vector<const Action*> rows;
  for (const auto& [score, action] : found) rows.push_back(action);
  return rows;
}

std::vector<const Action*> nearestActions(std::string_view typed) {
  constexpr size_t kMost = 5;
  std::vector<std::pair<double, const Action*>> found;
  for (const Action& action : actions()) {
    double sum = 0;
    eachWord(typed, [&](Text word) {
      sum += std::min(strangeness(word, action.name), 0.1 + strangeness(word, action.synonyms));
    });
    found.emplace_back(sum, &action);
  }
  std::stable_sort(found.begin(), found.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
  std::vector<const Action*> rows;
  for (size_t i = 0; i < std::min(kMost, found.size()); ++i) rows.push_back(found[i].second);
  return rows;
}

}  // namespace argil::studio
