// Clay out to files.

#include <algorithm>
#include <cmath>

#include "clay/cage/cage_maker.h"
#include "engine/models/cad_export.h"
#include "engine/models/export_cost.h"
#include "engine/models/export_presets.h"
#include "io/cad/cad_body.h"
#include "io/textured/textured_mesh.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace fs = std::filesystem;
namespace {

constexpr size_t kColumns = 4;
constexpr int kQuads = 3;  // ExportChoice::reduce
constexpr std::array kPixels = {0, 1024, 2048, 4096};

// The formats as switches; what the last one that is on is for, or what all have in common.
void formats(ExportChoice& choice) {
  kit::dimText("Formats");
  const float each = std::floor((ImGui::GetContentRegionAvail().x - float(kColumns - 1) * kGap) / float(kColumns));
  size_t shown = 0;
  const FileKind* only = nullptr;
  bool reduces = true;
  for (const FileKind& kind : fileKinds()) {
    if (kind.writes.empty()) continue;
    if (shown++ % kColumns > 0) ImGui::SameLine();
    const auto on = choice.endings.find(kind.ending);
    const bool chosen = on != choice.endings.end();
    if (chosen) {
      only = &kind;
      reduces &= kind.reduces;
    }
    if (kit::button(kind.name, chosen ? kit::Weight::chief : kit::Weight::plain, each)) {
      if (chosen)
        choice.endings.erase(on);
      else
        choice.endings.insert(std::string(kind.ending));
    }
  }
  if (choice.endings.size() == 1 && only)
    kit::wrapped(only->writes, colours().dim);
  else if (!choice.endings.empty())
    kit::wrapped("One file for each of them; lengths in mm, in metres where glTF wants it.", colours().dim);
  if (!reduces && choice.reduce != 0)
    kit::wrapped("A level set has no triangles: OpenVDB is written whole.", colours().warning);
}

// One click for who has a purpose and no opinion on formats.
void destinations(ExportChoice& choice) {
  kit::dimText("For");
  const std::span<const engine::ExportPreset> presets = engine::exportPresets();
  const float each = std::floor((ImGui::GetContentRegionAvail().x - float(kColumns - 1) * kGap) / float(kColumns));
  size_t shown = 0;
  for (const engine::ExportPreset& preset : presets) {
    if (shown++ % kColumns > 0) ImGui::SameLine();
    if (kit::button(preset.name, kit::Weight::plain, each)) {
      choice.endings = {preset.endings.begin(), preset.endings.end()};
      choice.reduce = preset.triangles ? 1 : preset.quads ? kQuads : 0;
      if (preset.quads) choice.quads = double(*preset.quads);
      for (size_t i = 0; preset.quads && i < kPixels.size(); ++i)
        if (kPixels[i] == preset.texturePixels) choice.textures = int(i);
      if (preset.triangles) choice.thousandTriangles = double(*preset.triangles) / 1000;
      choice.recentre = preset.recentre;
      if (choice.recentre) choice.putBack = false;
      choice.draco = preset.draco;
      choice.surface = 0;
    }
    kit::tooltip(preset.help);
  }
}

// Quads are made anew where they lie, and not packed.
bool quadsAlone(const ExportChoice& choice) {
  return choice.reduce == kQuads &&
         std::all_of(choice.endings.begin(), choice.endings.end(),
                     [](const std::string& ending) { return io::holdsTextures("a" + ending); });
}

// Chosen files that are smooth solids.
size_t cadFiles(const ExportChoice& choice) {
  return size_t(std::count_if(choice.endings.begin(), choice.endings.end(),
                              [](const std::string& ending) { return io::isCad("a" + ending); }));
}

// What is wished of quads and smooth faces beside their count.
void wishes(ExportChoice& choice) {
  kit::toggle("Along guides", choice.alongGuides,
              "Their edges follow the closed curves among the guides that are shown, where these lie on the clay.");
  kit::number({"density", "Where masked", "So many times as many for each mm²: paint what matters with the mask tool.",
               "×", 1 / clay::kMostMaskDensity, clay::kMostMaskDensity, 1, true},
              choice.maskDensity);
}

void reduction(ExportChoice& choice) {
  static constexpr std::array<std::string_view, 4> kHow{"All", "To a count", "Within an error", "Quads"};
  kit::dimText("Triangles");
  kit::segmented("reduce", kHow, choice.reduce);
  if (choice.reduce == 1)
    kit::number({"thousand", "At most", "In all; the error is told.", "thousand", 0.1, 50000, 200, true},
                choice.thousandTriangles);
  if (choice.reduce == 2)
    kit::number({"error", "Error at most", "Of the surface, measured both ways.", "mm", 0.0005, 10, 0.05, true},
                choice.errorMm);
  if (choice.reduce != kQuads) return;
  kit::number({"quads", "At most", "Of each piece; the error is told. More where so few would lie too far off.",
               "quads", 24, 100000, 4000, true},
              choice.quads);
  kit::toggle("Mirrored", choice.mirrored,
              "Where the clay is the same on both sides of a plane across an axis of its piece, its quads are too.");
  wishes(choice);
  static constexpr std::array<std::string_view, 4> kTextures{"None", "1024", "2048", "4096"};
  kit::dimText("Textures: the clay's normals, colours and heights, pixels a side");
  kit::segmented("textures", kTextures, choice.textures);
  if (!quadsAlone(choice))
    kit::wrapped("OBJ and GLB alone hold quads with textures: other files get all triangles.", colours().warning);
}

void smoothFaces(ExportChoice& choice) {
  static constexpr std::array<std::string_view, 2> kHow{"To a count", "Within an error"};
  kit::dimText("Smooth faces for CAD");
  kit::segmented("smooth", kHow, choice.smooth);
  if (choice.smooth == 0)
    kit::number({"faces", "At most", "Of each piece; the error is told.", "faces", 24, 20000, 500, true}, choice.faces);
  else
    kit::number({"smootherror", "Error at most",
                 "Both ways, with its bound; as few faces as a handful of tries finds. Places beyond it are told.",
                 "mm", 0.001, 10, 0.05, true},
                choice.smoothErrorMm);
  wishes(choice);
}

// Why it cannot be written; empty: it can.
std::string problemOf(const Context& context, const ExportChoice& choice) {
  std::error_code ignored;
  const engine::Document& document = *context.now.document;
  if (choice.name.empty() || choice.name.find('/') != std::string::npos) return "A name is needed, without a slash.";
  if (!fs::is_directory(choice.folder, ignored)) return "There is no folder " + choice.folder;
  if (choice.endings.empty()) return "Choose a format.";
  if (document.pieces.empty()) return "There is no clay to export.";
  if (choice.what == 2 && !document.piece(context.state.selected)) return "No piece of clay is selected.";
  return {};
}

bool cameFromElsewhere(const Context& context) {
  const auto& pieces = context.now.document->pieces;
  return std::any_of(pieces.begin(), pieces.end(),
                     [](const engine::Piece& each) { return !each.fileOffsetMm.isZero(0); });
}

engine::ModelExport optionsOf(const Context& context, const ExportChoice& choice) {
  engine::ModelExport options;
  options.visibleOnly = choice.what == 0;
  options.piece = choice.what == 2 ? context.state.selected : 0;
  options.grade = choice.surface == 0 ? clay::Grade::fine : clay::Grade::draft;
  if (choice.reduce == 1) options.triangles = uint64_t(std::llround(1000 * choice.thousandTriangles));
  if (choice.reduce == 2) options.errorMm = choice.errorMm;
  if (choice.reduce == kQuads) {
    options.quads = size_t(std::llround(choice.quads));
    options.texturePixels = kPixels[size_t(choice.textures)];
    options.mirrored = choice.mirrored;
  }
  if (choice.smooth == 0) {
    options.cadQuads = size_t(std::llround(choice.faces));
  } else {
    options.cadQuads = engine::kMostFacesWithin;
    options.cadErrorMm = choice.smoothErrorMm;
  }
  options.alongGuides = choice.alongGuides;
  options.maskDensity = choice.maskDensity;
  options.recentre = choice.recentre;
  options.putBack = choice.putBack && cameFromElsewhere(context);
  options.draco = choice.draco;
  return options;
}

// How many pieces go out.
size_t piecesOf(const engine::Document& document, const engine::ModelExport& what) {
  if (what.piece) return 1;
  return size_t(std::count_if(document.pieces.begin(), document.pieces.end(),
                              [&](const engine::Piece& each) { return each.visible || !what.visibleOnly; }));
}

// In the order in which they are offered: the first names the job.
std::vector<fs::path> filesOf(const ExportChoice& choice) {
  std::vector<fs::path> files;
  for (const FileKind& kind : fileKinds())
    if (choice.endings.contains(kind.ending))
      files.push_back(fs::path(choice.folder) / (choice.name + std::string(kind.ending)));
  return files;
}

// Files that would be written over, with those that come beside an OBJ of quads.
std::vector<std::string> existing(const std::vector<fs::path>& files, const ExportChoice& choice, size_t pieces) {
  std::vector<std::string> names;
  std::error_code ignored;
  for (const fs::path& file : files) {
    std::vector<fs::path> all = {file};
    if (choice.reduce == kQuads && file.extension() == ".obj")
      for (const std::string& name : io::texturedNames(file, pieces)) all.push_back(file.parent_path() / name);
    for (const fs::path& each : all)
      if (fs::exists(each, ignored)) names.push_back(each.filename().string());
  }
  return names;
}

}  // namespace

void drawExport(Context& context, Memory& memory) {
  ExportChoice& choice = memory.exporting;
  bool& open = context.state.shown.exporting;
  if (!kit::beginDialog("Export", "Export", 460, 0, &open)) return;
  std::error_code ignored;
  if (choice.name.empty() && ImGui::IsWindowAppearing()) choice.name = "clay";
  if (choice.folder.empty())
    choice.folder = context.state.lastFolder.empty() ? fs::current_path(ignored).string() : context.state.lastFolder;
  destinations(choice);
  formats(choice);
  static constexpr std::array<std::string_view, 3> kWhat{"What is visible", "Every piece", "Selected"};
  kit::dimText("What");
  kit::segmented("what", kWhat, choice.what);
  if (cadFiles(choice) > 0) smoothFaces(choice);
  const bool cadAlone = cadFiles(choice) > 0 && cadFiles(choice) == choice.endings.size();
  if (!cadAlone) {
    if (!quadsAlone(choice)) {  // which are drawn on a surface of their own
      static constexpr std::array<std::string_view, 2> kGrades{"Fine: sharp creases", "Draft"};
      kit::dimText("Surface");
      kit::segmented("surface", kGrades, choice.surface);
    }
    reduction(choice);
  }
  if (!cadAlone && !quadsAlone(choice) &&
      kit::toggle("Move it to zero", choice.recentre, "Numbers of 32 bits, as most formats have, are finest there.") &&
      choice.recentre)
    choice.putBack = false;
  if (cameFromElsewhere(context) &&
      kit::toggle("Where its file had it", choice.putBack, "Import moved it: this undoes that.") && choice.putBack)
    choice.recentre = false;
  if (!quadsAlone(choice) && (choice.endings.contains(".glb") || choice.endings.contains(".gltf")))
    kit::toggle("Pack glTF with Draco", choice.draco, "A tenth of the size; fewer programs can open it.");
  kit::dimText("Name and folder");
  bool asked = kit::textField("##name", choice.name, 0, "Name without ending", ImGui::IsWindowAppearing()) &&
               ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Enter), false);
  kit::textField("##folder", choice.folder, ImGui::GetContentRegionAvail().x - kRow - kGap, "Folder");
  ImGui::SameLine();
  if (kit::iconButton("folders", "folder", kRow, kit::Lit::off, "Choose a folder", "", "", false)) {
    memory.files.open({"Choose a folder", "Choose", {}, choice.folder});
    memory.filesFor = FilesFor::folder;
  }
  if (memory.filesFor == FilesFor::folder) {
    if (memory.files.draw()) choice.folder = memory.files.path().string();
    if (!memory.files.isOpen()) memory.filesFor = FilesFor::none;
  }

  const engine::ModelExport options = optionsOf(context, choice);
  const bool quads = std::any_of(choice.endings.begin(), choice.endings.end(),
                                 [](const std::string& ending) { return io::holdsTextures("a" + ending); });
  const size_t pieces = piecesOf(*context.now.document, options);
  std::string takes;
  if (const size_t cad = cadFiles(choice); cad > 0 || (quads && options.quads))
    takes = engine::sentence(engine::exportTime(options, pieces, quads, cad > 0, speedOf(memory)));
  const std::string problem = problemOf(context, choice);
  if (!problem.empty()) kit::wrapped(problem, colours().warning);
  const std::vector<fs::path> files = filesOf(choice);
  const std::vector<std::string> there = existing(files, choice, context.now.document->pieces.size());
  const bool asking = !choice.existing.empty() && choice.existing == there;
  if (asking) {
    std::string names;
    for (const std::string& name : there) names += (names.empty() ? "" : ", ") + name;
    kit::wrapped(
        names + (there.size() == 1 ? " is there already: write over it?" : " are there already: write over them?"),
        colours().warning);
  } else {
    choice.existing.clear();
  }
  kit::gap(6);
  const std::string_view verb = asking ? "Write over" : "Export";
  const float wide = 110, buttons = ImGui::GetWindowContentRegionMax().x - 2 * wide - kGap;
  // Beside the buttons: a row of its own would push them out of a low window.
  if (const float y = ImGui::GetCursorPosY(); !takes.empty()) {
    const float left = ImGui::GetCursorPosX();
    ImGui::SetCursorPosY(y + std::floor((kRow - ImGui::GetTextLineHeight()) / 2));
    kit::elided("Takes " + takes, buttons - left - kGap, colours().dim);
    ImGui::SetCursorPosY(y);
  }
  ImGui::SetCursorPosX(buttons);
  if (kit::button("Cancel", kit::Weight::plain, wide)) open = false;
  ImGui::SameLine();
  ImGui::BeginDisabled(!problem.empty());
  asked |= kit::mainButton(verb, wide, asking ? kit::Weight::danger : kit::Weight::chief);
  ImGui::EndDisabled();
  if (asked && problem.empty()) {
    if (!there.empty() && !asking) {
      choice.existing = there;
    } else {
      context.bench.exportTo(files, options);
      open = false;
    }
  }
  if (!open) choice.existing.clear();
  kit::endDialog(open);
}

}  // namespace argil::studio
