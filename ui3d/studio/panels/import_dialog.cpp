// A model that comes in: its unit, which of its axes points up, how large it will be. One page; Enter takes what is
// guessed.

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "io/bytes/input.h"
#include "ui3d/studio/kit/icons.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace fs = std::filesystem;
namespace {

struct UnitName {
  const char *id, *name;
};
constexpr std::array kUnits{UnitName{"mm", "Millimetres"}, UnitName{"cm", "Centimetres"},
                            UnitName{"m", "Metres"},       UnitName{"in", "Inches"},
                            UnitName{"ft", "Feet"},        UnitName{"um", "Micrometres"}};
// In the order of engine::UpAxis.
constexpr std::array<std::string_view, 6> kUps{"Z", "Y", "-Z", "-Y", "X", "-X"};
constexpr size_t kMostNotes = 3;
constexpr size_t kMostObjects = 6;    // that are listed
constexpr double kWorthSaying = 0.1;  // % of the surface
constexpr double kVoxelsAlong = 256;  // The longest side, where nobody says otherwise.
// Of clay for each square voxel of surface: a ball of 60 mm with voxels of 0.5 mm takes 3.4 MB.
constexpr double kBytesASquare = 75;

std::string units(int chosen) {
  return kUnits[size_t(std::clamp(chosen, 0, int(kUnits.size()) - 1))].id;
}

engine::ImportPlace wishOf(const AskedModel& asked) {
  return {units(asked.units), std::string(engine::upAxisNames()[size_t(asked.up)]), asked.heightMm, !asked.keepsPlace};
}

// Once the file has been read: what is guessed is chosen.
void takeGuess(AskedModel& asked) {
  const engine::ModelLook& look = *asked.look;
  for (size_t i = 0; i < kUnits.size(); ++i)
    if (look.units == kUnits[i].id) asked.units = int(i);
  asked.up = int(look.up);
}

// While the person looks at the page.
void measureWalls(AskedModel& asked) {
  asked.details = std::make_shared<engine::ModelDetails>();
  asked.measuring = std::make_unique<engine::BackgroundJob>(
      [details = asked.details, look = asked.look](Job& job) { *details = engine::detailsOf(*look, &job); });
}

void voxelRows(StudioState& state) {
  kit::toggle(kHalfMemory, state.imports.halfMemory, kHalfMemoryHelp);
  kit::toggle("Voxel size by hand", state.imports.voxelGiven,
              "Else as the file of an Argil document says, or 256 voxels along the longest side.");
  if (state.imports.voxelGiven)
    kit::number({"voxel", "Voxel", "Finer shows more and costs more.", "mm", 0.01, 10, 0.5, true},
                state.imports.voxelMm);
}

void unitRow(AskedModel& asked) {
  static constexpr auto names = [] {
    std::array<std::string_view, kUnits.size()> result;
    for (size_t i = 0; i < kUnits.size(); ++i) result[i] = kUnits[i].name;
    return result;
  }();
  if (kit::choice("Numbers are", names, asked.units, "The file names no unit: guessed by its size and kind."))
    asked.heightMm.reset();
}

// What the file holds beside one plain mesh, and what of it is not kept.
void contentRows(const io::ModelFile& model, const engine::ModelDetails* details, bool asPart) {
  const auto painted = [](const io::ModelObject& each) {
    return !each.vertexColours.empty() || !each.triangleColours.empty();
  };
  std::string objects = std::to_string(model.objects.size());
  if (!model.negatives.empty())
    objects += fmt::format(", {} {}", model.negatives.size(), asPart ? "left out (cut away in clay)" : "cut away");
  if (model.objects.size() > 1 || !model.negatives.empty()) kit::fact("Objects", objects);
  const bool known = details && details->solid.size() == model.objects.size();
  const auto row = [](const io::ModelObject& object, const char* kind) {
    kit::fact("    " + (object.name.empty() ? "without a name" : object.name), kind);
  };
  if (model.objects.size() > 1 && model.objects.size() + model.negatives.size() <= kMostObjects) {
    for (size_t i = 0; i < model.objects.size(); ++i)
      row(model.objects[i], !known ? "…" : details->solid[i] ? "solid" : "open");
    for (const io::ModelObject& negative : model.negatives) row(negative, asPart ? "left out" : "cut away");
  } else if (model.objects.size() == 1) {
    kit::fact("Closed", !known ? "…" : details->solid[0] ? "yes" : asPart ? "no" : "no: clay closes holes");
  }
  if (std::any_of(model.objects.begin(), model.objects.end(), painted))
    kit::fact("Colours", asPart ? "one, the mean" : "kept");
  for (size_t i = 0; i < std::min(model.notes.size(), kMostNotes); ++i)
    kit::wrapped(kit::sentence(model.notes[i]), colours().dim);
}

double voxelOf(const AskedModel& asked, const StudioState& state, const engine::Placement& placement) {
  if (!asked.keepsWalls && !state.imports.voxelGiven && !asked.heightMm)
    if (const std::vector<double> saved = engine::savedVoxelsMm(*asked.look->model); !saved.empty())
      return *std::min_element(saved.begin(), saved.end());
  if (asked.keepsWalls) return asked.details->walls.keepingVoxelMm() * placement.mm * placement.scale;
  return state.imports.voxelGiven ? state.imports.voxelMm : placement.sizeMm.maxCoeff() / kVoxelsAlong;
}

// What voxels of this size lose, and those that lose nothing. The rows are there before walls are known: the button
// below them must not move away from the hand that is about to press it.
void wallRows(AskedModel& asked, double voxel, const engine::Placement& placement) {
  if (!(voxel > 0)) return;
  const bool known = asked.measuring && asked.measuring->done();
  const double mm = placement.mm * placement.scale;
  const double keeping = known ? asked.details->walls.keepingVoxelMm() * mm : 0;
  const double share = known ? 100 * asked.details->walls.shareThinner(voxel / mm) : 0;
  const bool loses = share > kWorthSaying;
  kit::fact("Walls thinner than a voxel",
            !known                             ? "…"
            : loses                            ? fmt::format("{:.2g} % of the surface", share)
            : asked.details->walls.points == 0 ? "not looked for"
                                               : "none",
            loses ? colours().warning : 0);
  ImGui::BeginDisabled(!(loses || asked.keepsWalls) || !(keeping > 0));
  kit::toggle("Voxels that keep every wall", asked.keepsWalls,
              "As fine as the thinnest wall" + (keeping > 0 ? ": " + kit::written(keeping) + " mm." : "."));
  ImGui::EndDisabled();
}

// The size as it will be, and what decides it.
void sizeRows(AskedModel& asked, StudioState& state) {
  const engine::ModelLook& look = *asked.look;
  const engine::Placement placement = engine::placementOf(look, wishOf(asked));
  ImGui::PushFont(fonts().strong);
  kit::fact("Width × depth × height", engine::sizeWords(placement.sizeMm));
  ImGui::PopFont();
  if (look.unitsSaid)
    kit::fact("Numbers are", engine::unitName(look.units) + ", as the file says");
  else
    unitRow(asked);
  kit::choice("Upwards in the file", kUps, asked.up,
              "Guessed by the shape and the kind of file. The model is turned until it points up.");
  double height = placement.sizeMm.z();
  if (height > 0 &&
      kit::number({"height", "Height", "Drag, or double-click to type: the model is scaled until it is so high.", "mm",
                   1e-3, 1e6, height, true},
                  height)
          .changed)
    asked.heightMm = height;
  contentRows(*look.model, asked.measuring->done() ? asked.details.get() : nullptr, asked.asPart);
  kit::toggle("Where the file has it", asked.keepsPlace, "Else it stands on the ground, beside what is there.");
  if (!asked.asDocument) kit::toggle("As a part: seen and felt, not clay", asked.asPart);
  const auto hasFaces = [](const io::ModelObject& object) { return !object.faces.empty(); };
  if (std::any_of(look.model->objects.begin(), look.model->objects.end(), hasFaces))
    kit::toggle("Guides of its faces", asked.guides, "Planes, axes and middles of the largest faces, to snap to.");
  if (asked.asPart) return;
  const double voxel = voxelOf(asked, state, placement);
  const double area = look.area * placement.mm * placement.mm * placement.scale * placement.scale;
  if (voxel > 0)
    kit::fact("Clay, about", "voxels of " + kit::written(voxel) + " mm, " +
                                 kit::bytes(uint64_t(kBytesASquare * area / (voxel * voxel))));
  wallRows(asked, voxel, placement);
  if (kit::button(asked.more ? "Voxels  −" : "Voxels  +", kit::Weight::plain, ImGui::GetContentRegionAvail().x))
    asked.more = !asked.more;
  if (asked.more) voxelRows(state);
}

engine::Workbench::ImportOptions optionsOf(const AskedModel& asked, const StudioState& state) {
  engine::Workbench::ImportOptions options;
  const engine::ImportPlace wish = wishOf(asked);
  options.units = wish.units;
  options.up = wish.up;
  options.heightMm = wish.heightMm;
  options.stands = wish.stands;
  options.look = asked.look;
  if (!asked.look) {  // A level set is the clay that it is.
    options.up.clear();
    options.stands = false;
  }
  options.asPart = asked.asPart;
  options.guides = asked.guides;
  if (asked.keepsWalls && !asked.asPart)
    options.voxelMm = voxelOf(asked, state, engine::placementOf(*asked.look, wish));
  else if (state.imports.voxelGiven && !asked.asPart)
    options.voxelMm = state.imports.voxelMm;
  if (state.imports.halfMemory) options.precision = clay::Precision::fixed16;
  return options;
}

void bringIn(Context& context, Memory& memory, const AskedModel& asked) {
  engine::Workbench::ImportOptions options = optionsOf(asked, context.state);
  if (asked.asDocument) {
    Departure departure{Departure::To::file, asked.file};
    departure.import = std::move(options);
    depart(context, memory, std::move(departure));
    return;
  }
  context.bench.import(asked.file, options);
  context.state.lastFolder = asked.file.parent_path().string();
  context.state.shown.firstStart = false;
}

}  // namespace

void askModel(Memory& memory, const fs::path& file, bool asDocument, bool asPart) {
  AskedModel asked;
  asked.file = file;
  asked.asDocument = asDocument;
  asked.asPart = asPart;
  if (io::endingOf(file) != ".vdb") {
    asked.look = std::make_shared<engine::ModelLook>();
    asked.reading = std::make_unique<engine::BackgroundJob>(
        [look = asked.look, file](Job& job) { *look = engine::lookAtModel(file, &job); });
  }
  memory.asked = std::move(asked);
}

void drawAsked(Context& context, Memory& memory) {
  if (memory.asked.file.empty() && !memory.toBeAsked.empty()) {
    const fs::path next = std::move(memory.toBeAsked.front());
    memory.toBeAsked.pop_front();
    askModel(memory, next, false, false);
  }
  std::erase_if(memory.ending, [](const auto& job) { return job->done(); });
  bool open = !memory.asked.file.empty();
  if (!kit::beginDialog("Asked", memory.asked.asDocument ? "Open a model" : "Import a model", 420, 0, &open)) return;
  AskedModel& asked = memory.asked;
  const bool entered = !ImGui::IsWindowAppearing() && !ImGui::GetIO().WantTextInput &&
                       (ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Enter), false) ||
                        ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_KeyPadEnter), false));
  kit::elided(asked.file.filename().string(), ImGui::GetContentRegionAvail().x, colours().dim);
  if (!memory.toBeAsked.empty()) kit::fact("Files after it", std::to_string(memory.toBeAsked.size()));
  bool ready = true;
  std::string trouble;
  if (asked.reading) {
    ready = asked.reading->done();
    if (ready) {
      try {
        asked.reading->wait();
        if (asked.look->units.empty() || !asked.look->model)
          throw Error("the model could not be read", Error::Kind::work);
        if (!asked.guessed) takeGuess(asked), measureWalls(asked);
        asked.guessed = true;
        sizeRows(asked, context.state);
      } catch (const std::exception& e) {
        trouble = e.what();
      }
    } else {
      kit::text("Reading…");
      kit::bar(asked.reading->job().fraction(), ImGui::GetContentRegionAvail().x);
      asked.accepted |= entered;
    }
    memory.moves |= !ready || (asked.measuring && !asked.measuring->done());
  } else if (asksForUnits(asked.file)) {
    unitRow(asked);
  }
  if (!trouble.empty()) kit::wrapped(kit::sentence(trouble), colours().error);
  kit::gap(6);
  ImGui::SetCursorPosX(ImGui::GetWindowWidth() - 18 - 2 * 96 - kGap);
  if (kit::button("Cancel", kit::Weight::plain, 96)) open = false;
  ImGui::SameLine();
  const bool can = ready && trouble.empty();
  ImGui::BeginDisabled(!can);
  bool chosen = kit::mainButton(asked.asDocument ? "Open" : "Import", 96);
  ImGui::EndDisabled();
  chosen = can && (chosen || entered || asked.accepted);
  kit::endDialog(open && !chosen);
  if (open && !chosen) return;
  AskedModel over = std::move(memory.asked);
  memory.asked = {};
  for (auto* job : {&over.reading, &over.measuring}) {
    if (!*job || (*job)->done()) continue;
    (*job)->job().cancel();
    memory.ending.push_back(std::move(*job));
  }
  if (chosen) bringIn(context, memory, over);
}

}  // namespace argil::studio
