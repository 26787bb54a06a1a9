// Operations on whole pieces: which pieces, which plane or curve, which numbers.

#include <algorithm>
#include <cmath>
#include <thread>
#include <utility>

#include "clay/whole/deform.h"
#include "ui3d/studio/kit/rows.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/view/camera.h"
#include "ui3d/studio/widgets/guide_places.h"

namespace argil::studio {
namespace {

using engine::Guide;
using std::string_view;
using Parameter = engine::Parameter<engine::PieceArguments>;

constexpr float kWidth = 400;

// A list to choose from; what was chosen may have gone.
bool choose(string_view name, const std::vector<std::string>& names, int& chosen, string_view help = {}) {
  chosen = std::clamp(chosen, 0, std::max(0, int(names.size()) - 1));
  const std::vector<string_view> views(names.begin(), names.end());
  return kit::choice(name, views, chosen, help);
}

// Numbers that stand for a few possibilities, in words.
struct Words {
  string_view id;
  bool curve;  ///< Of operations that take a curve.
  double low;
  std::array<string_view, 3> words;
};
constexpr std::array kWords{Words{"keep", false, -1, {"Behind it", "Both sides", "Before it"}},
                            Words{"keep", true, -1, {"Outside, right", "Both", "Inside, left"}},
                            Words{"axis", false, 1, {"x", "y", "z"}}};

void drawNumber(const Parameter& row, bool curve, engine::PieceArguments& arguments) {
  if (row.unit.empty() && row.choices.empty() && row.low == 0 && row.high == 1) {
    bool on = row.get(arguments) > 0.5;
    if (kit::toggle(row.name, on, row.help)) row.change(arguments, on ? 1 : 0);
    return;
  }
  const auto words = std::find_if(kWords.begin(), kWords.end(), [&](const Words& each) {
    return each.id == row.id && each.curve == curve && each.low == row.low && row.high == row.low + 2;
  });
  if (!row.unit.empty() || words == kWords.end()) {
    drawRow(row, arguments);
    return;
  }
  kit::dimText(row.name);
  kit::tooltip(row.help);
  int chosen = static_cast<int>(std::lround(row.get(arguments) - row.low));
  if (kit::segmented(row.id.data(), words->words, chosen)) row.change(arguments, row.low + chosen);
}

std::vector<NamedPlane> planesFor(const Context& context, Operation& operation, const engine::Piece* piece) {
  std::optional<Vec3d> middleMm;
  if (piece && piece->version && piece->version.stats().bricks > 0) {
    if (operation.measured != piece->version) {
      const clay::BoxMm box = clay::boundsOf(piece->version);
      operation.middleMm = piece->pose.apply((box.low + box.high) / 2);
      operation.measured = piece->version;
    }
    middleMm = operation.middleMm;
  }
  return planesOf(*context.now.document, context.state.selected, middleMm);
}

// Which piece, or which two. Returns the first; null: there is none.
const engine::Piece* drawPieces(const Context& context, Operation& operation) {
  const engine::Document& document = *context.now.document;
  std::vector<engine::Id>& ids = operation.arguments.pieces;
  ids.resize(size_t(operation.row->pieces), 0);
  static constexpr std::array<string_view, 2> kNames{"Piece", "With"};
  for (size_t i = 0; i < ids.size(); ++i) {
    std::vector<std::string> names;
    std::vector<engine::Id> of;
    for (const engine::Piece& piece : document.pieces) {
      if (i == 1 && piece.id == ids[0]) continue;
      names.push_back(piece.name);
      of.push_back(piece.id);
    }
    if (of.empty()) return nullptr;
    int chosen = int(std::find(of.begin(), of.end(), ids[i]) - of.begin());
    if (chosen == int(of.size())) chosen = 0;
    choose(kNames[i], names, chosen);
    ids[i] = of[size_t(chosen)];
  }
  return ids.empty() ? nullptr : document.piece(ids[0]);
}

// Empty, or what is missing.
std::string drawPlane(const Context& context, Operation& operation, const engine::Piece* piece) {
  const std::vector<NamedPlane> planes = planesFor(context, operation, piece);
  if (planes.empty()) return "There is no plane yet: add one from the Guides menu.";
  std::vector<std::string> names;
  for (const NamedPlane& plane : planes) names.push_back(plane.name);
  choose("Plane", names, operation.plane);
  kit::toggle("Turn the plane round", operation.turned, "It faces the other way.");
  operation.arguments.plane = planes[size_t(operation.plane)].plane;
  if (operation.turned) operation.arguments.plane.normal *= -1;
  return {};
}

std::string drawCurve(const Context& context, Operation& operation) {
  std::vector<std::string> names;
  std::vector<const Guide*> curves;
  for (const Guide& guide : context.now.document->guides) {
    if (guide.kind != Guide::Kind::curve || guide.pointsMm.size() < 2) continue;
    const bool first = guide.id == context.state.selected;
    names.insert(first ? names.begin() : names.end(), guide.name);
    curves.insert(first ? curves.begin() : curves.end(), &guide);
  }
  if (curves.empty()) return "There is no curve yet: add one from the Guides menu.";
  choose("Curve", names, operation.curve);
  static constexpr std::array<string_view, 4> kDirections{"View", "x", "y", "z"};
  kit::dimText("It goes through the clay along");
  kit::segmented("direction", kDirections, operation.direction);
  const Guide& curve = *curves[size_t(operation.curve)];
  operation.arguments.pointsMm = placesAlong(curve);
  operation.arguments.closed = curve.closed;
  // The first again.
  if (curve.closed && operation.arguments.pointsMm.size() > 3) operation.arguments.pointsMm.pop_back();
  operation.arguments.directionMm =
      operation.direction == 0 ? context.camera.view().axes().forward : Vec3d(Vec3d::Unit(operation.direction - 1));
  return {};
}

// The two pieces of a combination, where they have clay.
std::pair<const engine::Piece*, const engine::Piece*> combined(const engine::Document& document,
                                                               const Operation& operation) {
  const std::vector<engine::Id>& ids = operation.arguments.pieces;
  if (operation.row->group != "Combine" || operation.row->pieces != 2 || ids.size() != 2 || ids[0] == ids[1]) return {};
  const engine::Piece *first = document.piece(ids[0]), *second = document.piece(ids[1]);
  if (!first || !second || !first->version || !second->version) return {};
  return {first, second};
}

// How far what the picture shows of an offset is from what it will be.
void drawPreviewLimits(const engine::PieceJob& row, const engine::PieceArguments& arguments,
                       const engine::Piece& piece) {
  if (!row.growsMm || arguments.pieces.size() != 1 || !piece.version) return;
  // An edge that is to be round with this radius is shown flat: off by 0.3 of it, a voxel's width from here on.
  constexpr double kRightVoxels = 3;
  const double mm = row.growsMm(arguments);
  if (mm > kRightVoxels * piece.version.grid().voxelMm)
    kit::wrapped("The picture shows it roughly: edges will be round, and gaps narrower than " + kit::written(2 * mm) +
                     " mm will close.",
                 colours().dim);
}

// For each pair of pieces anew; what the user sets for a pair stays.
void proposeVoxel(const engine::Document& document, Operation& operation) {
  const auto [first, second] = combined(document, operation);
  if (!first || std::exchange(operation.costOf, operation.arguments.pieces) == operation.arguments.pieces) return;
  operation.arguments.change<engine::CombineValues>().voxelMm =
      engine::combineCost(*operation.row, *first, *second, 0).voxelMm;
}

// Whose voxels the result gets, as one choice where the pieces differ; the number below it is for all others.
void drawWhoseVoxels(const engine::Document& document, Operation& operation) {
  const auto [first, second] = combined(document, operation);
  if (!first || first->version.grid().voxelMm == second->version.grid().voxelMm) return;
  double& voxel = operation.arguments.change<engine::CombineValues>().voxelMm;
  const std::array<double, 3> sizes{first->version.grid().voxelMm, second->version.grid().voxelMm,
                                    engine::combineCost(*operation.row, *first, *second, 0).voxelMm};
  std::vector<std::string> names;
  for (size_t i = 0; i < 2; ++i)
    names.push_back((i == 0 ? first : second)->name + "'s: " + kit::written(sizes[i]) + " mm");
  const bool between = sizes[2] != sizes[0] && sizes[2] != sizes[1];
  if (between) names.push_back("Between: " + kit::written(sizes[2]) + " mm");
  const auto found = std::find(sizes.begin(), sizes.begin() + ptrdiff_t(names.size()), voxel);
  int chosen = int(found - sizes.begin());
  if (size_t(chosen) == names.size()) names.push_back("Other: " + kit::written(voxel) + " mm");
  const std::vector<string_view> views(names.begin(), names.end());
  if (kit::choice("Voxels of", views, chosen,
                  "The result has one voxel size: finer keeps more detail and takes more memory.") &&
      chosen < 3)
    voxel = sizes[size_t(chosen)];
}

// What the result has, before it is made.
void drawCost(const engine::Document& document, const Operation& operation) {
  const auto [first, second] = combined(document, operation);
  if (!first) return;
  const engine::CombineCost cost =
      engine::combineCost(*operation.row, *first, *second, operation.arguments.get<engine::CombineValues>().voxelMm);
  for (const engine::Piece* piece : {first, second})
    kit::fact(piece->name, "voxels of " + kit::written(piece->version.grid().voxelMm) + " mm, " +
                               kit::bytes(piece->version.stats().bytes()));
  kit::fact("Result, about", "voxels of " + kit::written(cost.voxelMm) + " mm, " + kit::bytes(cost.bytes));
}

// What it would take, and whether it can be; anew where something changed. Empty, or why not.
std::string drawPrice(const engine::Document& document, Operation& operation, const engine::MachineSpeed& machine) {
  std::vector<clay::Version> clay;
  for (const engine::Id id : operation.arguments.pieces)
    if (const engine::Piece* piece = document.piece(id)) clay.push_back(piece->version);
  if (clay.size() != operation.arguments.pieces.size()) return {};
  if (!operation.price || operation.price->clay != clay || !(operation.price->arguments == operation.arguments)) {
    Operation::Price price{operation.arguments, std::move(clay), {}, {}};
    try {
      price.cost = engine::costOf(*operation.row, document, operation.arguments, machine);
      engine::requireMemoryFor(*operation.row, document, operation.arguments, price.cost);
    } catch (const Error& error) {
      price.problem = error.what();
    }
    operation.price = std::move(price);
  }
  if (operation.row->added)
    kit::fact("Takes", "as long as the plugin needs");
  else
    kit::fact("Takes", engine::sentence(operation.price->cost, int(std::thread::hardware_concurrency())));
  return operation.price->problem;
}

// The bed and the pull are those of the print check: what is chosen here is chosen there. `back`: from the operation.
void sharePrintChoice(const engine::PieceJob& row, engine::PieceArguments& arguments, PrintChoice& print, bool back) {
  const auto share = [&](string_view id, double& value) {
    for (const Parameter& parameter : row.parameters) {
      if (parameter.id != id) continue;
      if (back)
        value = parameter.get(arguments);
      else
        parameter.change(arguments, value);
    }
  };
  if (row.id == "nest") {
    share("width", print.bedMm.x());
    share("depth", print.bedMm.y());
  }
  if (row.id != "mould") return;
  // There the best pull comes first, and nothing is not cast.
  double pull = print.pull == PrintChoice::kBestPull ? 0 : print.pull;
  if (!back && print.pull == 0) return;
  share("pull", pull);
  if (back) print.pull = pull == 0 ? PrintChoice::kBestPull : int(std::lround(pull));
}

}  // namespace

void beginOperation(Context& context, Memory& memory, std::string_view id) {
  const engine::PieceJob* row = engine::findPieceJob(id);
  if (!row) return;
  Operation operation;
  operation.row = row;
  operation.arguments = engine::standardArguments(*row, *context.now.document);
  const auto last = memory.operations.find(row->id);
  const engine::Piece* selected = context.now.document->piece(context.state.selected);
  if (row->pieces > 0 && selected) operation.arguments.pieces = {selected->id};
  for (const engine::Id other : context.state.selection())
    if (selected && other != selected->id && context.now.document->piece(other) &&
        operation.arguments.pieces.size() < size_t(row->pieces))
      operation.arguments.pieces.push_back(other);
  const engine::Piece* piece =
      operation.arguments.pieces.empty() ? nullptr : context.now.document->piece(operation.arguments.pieces[0]);
  for (const Parameter& parameter : row->parameters) {
    if (last != memory.operations.end() && parameter.id != "voxel")
      parameter.change(operation.arguments, parameter.get(last->second));
    if (parameter.id == "voxel" && piece && piece->version)
      parameter.change(operation.arguments, piece->version.grid().voxelMm);
  }
  sharePrintChoice(*row, operation.arguments, context.state.print, false);
  memory.operation = std::move(operation);
}

namespace {

// Shows clay that becomes thinner as it was worked out: beside edges, vertices that move inwards would pass those of
// the other face and stand out like fins.
std::optional<GrownPiece> grownBy(const engine::PieceJob& row, const engine::PieceArguments& arguments,
                                  const OffsetPreview& inwards) {
  if (!row.growsMm || arguments.pieces.size() != 1) return std::nullopt;
  const double mm = row.growsMm(arguments);
  if (mm > 0) return GrownPiece{.piece = arguments.pieces[0], .mm = mm};
  if (mm < 0 && inwards.shape) return GrownPiece{.piece = arguments.pieces[0], .shape = inwards.shape};
  return std::nullopt;
}

// What is asked about, else what was begun and is not there yet.
void followGrown(Context& context, const Memory& memory, bool valid) {
  const Operation& asked = memory.operation;
  StudioState& state = context.state;
  if (state.growing && context.bench.idle()) {
    // Cancelled, or refused: no surface comes. What was made is another version by now, if not in what this frame began
    // with: a job is gone from the list before its result is in the document.
    const std::shared_ptr<const engine::Snapshot> now = context.bench.snapshot();
    const engine::Piece* piece = now->document->piece(state.growing->piece);
    if (!piece || piece->version == state.growing->before) state.growing.reset();
  }
  state.grown = state.growing;
  if (asked.row && valid) state.grown = grownBy(*asked.row, asked.arguments, memory.offset);
}

}  // namespace

void drawOperation(Context& context, Memory& memory) {
  Operation& operation = memory.operation;
  bool open = operation.row != nullptr;
  // The preview of the result stands in the middle of the picture, the dialog beside it.
  const bool shows = open && (operation.row->growsMm || operation.row->id == "cut-pegs");
  const float right = shows ? memory.layout.free.right - kPad : 0;
  if (!kit::beginDialog("Operation", open ? operation.row->name.data() : "Operation", kWidth, 0, &open, right)) {
    (void)followPegs(context, memory, nullptr);
    (void)followOffset(context, memory, nullptr);
    return followGrown(context, memory, false);
  }
  const engine::PieceJob& row = *operation.row;
  kit::wrapped(row.help, colours().dim);
  kit::gap(4);
  const engine::Piece* piece = drawPieces(context, operation);
  std::string problem = row.pieces > 0 && !piece ? "There are not enough pieces of clay." : "";
  for (const engine::Id id : operation.arguments.pieces)
    if (const engine::Piece* each = context.now.document->piece(id); each && each->locked)
      problem = each->name + " is locked: unlock it first.";
  if (row.takesPlane)
    if (const std::string missing = drawPlane(context, operation, piece); !missing.empty()) problem = missing;
  if (row.takesCurve)
    if (const std::string missing = drawCurve(context, operation); !missing.empty()) problem = missing;
  proposeVoxel(*context.now.document, operation);
  drawWhoseVoxels(*context.now.document, operation);
  for (const Parameter& parameter : row.parameters) drawNumber(parameter, row.takesCurve, operation.arguments);
  if (problem.empty()) {
    drawCost(*context.now.document, operation);
    problem = drawPrice(*context.now.document, operation, speedOf(memory));
  }
  if (const std::string none = followPegs(context, memory, problem.empty() ? piece : nullptr); !none.empty())
    problem = kit::sentence(none);
  if (const std::string none = followOffset(context, memory, problem.empty() ? piece : nullptr); !none.empty())
    problem = kit::sentence(none);
  if (problem.empty() && piece) drawPreviewLimits(row, operation.arguments, *piece);
  if (!problem.empty()) kit::wrapped(problem, colours().warning);
  kit::gap(6);
  const float wide = std::max(96.0f, kit::buttonWidth(row.name));
  ImGui::SetCursorPosX(ImGui::GetWindowContentRegionMax().x - 2 * wide - kGap);
  if (kit::button("Cancel", kit::Weight::plain, wide)) open = false;
  ImGui::SameLine();
  ImGui::BeginDisabled(!problem.empty());
  if (kit::mainButton(row.name, wide)) {
    memory.operations[row.id] = operation.arguments;
    sharePrintChoice(row, operation.arguments, context.state.print, true);
    context.bench.operate(std::string(row.id), operation.arguments);
    if (memory.offset.job) memory.offset.shape.reset();  // It shows what was asked about before.
    context.state.growing = grownBy(row, operation.arguments, memory.offset);
    if (context.state.growing) context.state.growing->before = piece->version;
    open = false;
  }
  ImGui::EndDisabled();
  followGrown(context, memory, problem.empty() && open);
  if (!open) operation.row = nullptr;
  kit::endDialog(open);
}

}  // namespace argil::studio
