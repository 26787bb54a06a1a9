// Opening, importing, exporting, new clay, preferences, the first page.

#include <algorithm>
#include <cmath>
#include <utility>

#include "ui3d/studio/panels/icons.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/panels/panel_table.h"
#include "ui3d/studio/panels/theme.h"

namespace argil::studio {
namespace fs = std::filesystem;
namespace {

constexpr std::array<std::string_view, 3> kEndings{".stl", ".obj", ".ply"};
constexpr std::array<std::string_view, 3> kFormats{"STL", "OBJ", "PLY"};
constexpr std::array<std::string_view, 4> kUnits{"mm", "cm", "m", "in"};
const std::vector<std::string> kMeshes{".stl", ".obj", ".ply", ".off"};

void openFiles(Memory& memory, const char* title, const char* verb, std::vector<std::string> endings, const std::string& where = {}) {
  memory.files.open({title, verb, std::move(endings), where});
}

void importMore(Memory& memory) {
  engine::Workbench::ImportOptions& options = memory.importOptions;
  kit::choice("Units of the file", kUnits, memory.importUnits, "These files name none: a wrong choice makes the model too large or too small.");
  kit::toggle("As a part: seen and felt, not clay", options.asPart);
  if (options.asPart) return;
  kit::toggle("Voxel size by hand", memory.importVoxelGiven, "Else 256 voxels along the longest side.");
  if (memory.importVoxelGiven) kit::number({"voxel", "Voxel", "Finer shows more and costs more.", "mm", 0.01, 10, 0.5, true}, memory.importVoxelMm);
}

void import(Context& context, Memory& memory, const fs::path& file) {
  engine::Workbench::ImportOptions options = memory.importOptions;
  options.units = kUnits[size_t(memory.importUnits)];
  options.voxelMm.reset();
  if (memory.importVoxelGiven && !options.asPart) options.voxelMm = memory.importVoxelMm;
  context.bench.import(file, options);
}

void remember(StudioState& state, const fs::path& file) {
  constexpr size_t kMost = 8;
  std::erase(state.recentFiles, file.string());
  state.recentFiles.insert(state.recentFiles.begin(), file.string());
  if (state.recentFiles.size() > kMost) state.recentFiles.resize(kMost);
}

engine::Workbench::ImportOptions optionsFor(bool part) {
  engine::Workbench::ImportOptions options;
  options.asPart = part;
  return options;
}

// One of the three things to begin with.
bool bigButton(std::string_view icon, std::string_view name, std::string_view help) {
  const float width = ImGui::GetContentRegionAvail().x, height = 58;
  ImGui::PushID(name.data());
  const bool pressed = ImGui::InvisibleButton("big", {width, height});
  ImGui::PopID();
  const bool hovered = ImGui::IsItemHovered();
  const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const Colours& c = colours();
  list.AddRectFilled(a, b, hovered ? c.fieldHover : c.field, 7);
  list.AddRect(a, b, hovered ? c.accent : c.line, 7, 0, 1);
  drawIcon(list, icon, {a.x + 31, (a.y + b.y) / 2}, 26, c.accent);
  ImGui::PushFont(fonts().strong);
  list.AddText({a.x + 60, a.y + 11}, c.text, name.data(), name.data() + name.size());
  ImGui::PopFont();
  list.AddText({a.x + 60, a.y + 31}, c.dim, help.data(), help.data() + help.size());
  return pressed;
}

void begin(Context& context, const fs::path& file) {
  context.state.selected = 0;
  if (file.empty()) {
    context.bench.newDocument();
    return;
  }
  context.bench.open(file);
  remember(context.state, file);
  context.state.shown.firstStart = false;
}

}  // namespace

void beginDocument(Context& context, Memory& memory, const fs::path& file) {
  // A block that was just added, or a file that was just opened, is one step: nobody's work.
  if (context.now.done <= 1 || context.now.document == context.bench.exported()) begin(context, file);
  else memory.beginning = file;
}

void drawBeginning(Context& context, Memory& memory) {
  bool open = memory.beginning.has_value();
  if (!kit::beginDialog("Beginning", "Begin anew?", 420, 0, &open)) return;
  kit::wrapped("What was done since the last export is lost: there is no undo for it.", colours().text);
  kit::gap(6);
  const float wide = 110;
  ImGui::SetCursorPosX(ImGui::GetWindowWidth() - 18 - 3 * wide - 2 * kGap);
  if (kit::button("Cancel", kit::Weight::plain, wide)) open = false;
  ImGui::SameLine();
  if (kit::button("Export…", kit::Weight::plain, wide)) {
    open = false;
    context.state.wishes.dialog = "export";
  }
  ImGui::SameLine();
  if (kit::button("Begin anew", kit::Weight::danger, wide)) {
    begin(context, *memory.beginning);
    open = false;
  }
  if (!open) memory.beginning.reset();
  kit::endDialog(open);
}

void serveWishes(Context& context, Memory& memory) {
  const std::string wish = std::exchange(context.state.wishes.dialog, {});
  if (wish == "new") {
    beginDocument(context, memory, {});
  } else if (wish == "open") {
    std::vector<std::string> endings = kMeshes;
    endings.push_back(".json");
    openFiles(memory, "Open as a new document", "Open", endings);
    memory.filesFor = FilesFor::open;
  } else if (wish == "import" || wish == "part") {
    memory.importOptions = optionsFor(wish == "part");
    openFiles(memory, wish == "part" ? "Import as a part" : "Import as clay", "Import", kMeshes);
    memory.filesFor = FilesFor::import;
  } else if (wish == "clay") {
    memory.newClayOpen = true;
  } else if (wish.starts_with("export")) {
    for (size_t i = 0; i < kEndings.size() && wish.size() > 6; ++i) memory.exporting.formats[i] = wish.substr(6) == kEndings[i];
    context.state.shown.exporting = true;
  }
}

void drawFiles(Context& context, Memory& memory) {
  if (memory.filesFor == FilesFor::open) {
    if (memory.files.draw()) beginDocument(context, memory, memory.files.path());
  } else if (memory.filesFor == FilesFor::import) {
    const int rows = memory.importOptions.asPart ? 2 : memory.importVoxelGiven ? 4 : 3;
    if (memory.files.draw([&] { importMore(memory); }, float(rows) * (kRow - 2 + kGap))) {
      import(context, memory, memory.files.path());
      context.state.shown.firstStart = false;
    }
  }
}

void drawDropped(Context& context, Memory& memory) {
  bool open = !memory.dropped.empty();
  if (!kit::beginDialog("Dropped", "Import", 420, 0, &open)) return;
  kit::elided(fs::path(memory.dropped).filename().string(), ImGui::GetContentRegionAvail().x, colours().dim);
  importMore(memory);
  kit::gap(6);
  ImGui::SetCursorPosX(ImGui::GetWindowWidth() - 18 - 2 * 96 - kGap);
  if (kit::button("Cancel", kit::Weight::plain, 96)) open = false;
  ImGui::SameLine();
  if (kit::button("Import", kit::Weight::chief, 96)) {
    import(context, memory, memory.dropped);
    context.state.shown.firstStart = false;
    open = false;
  }
  if (!open) memory.dropped.clear();
  kit::endDialog(open);
}

void drawExport(Context& context, Memory& memory) {
  ExportChoice& choice = memory.exporting;
  bool& open = context.state.shown.exporting;
  if (!kit::beginDialog("Export", "Export", 460, 0, &open)) return;
  std::error_code ignored;
  if (choice.folder.empty()) choice.folder = fs::current_path(ignored).string();
  kit::dimText("Formats");
  const float each = std::floor((ImGui::GetContentRegionAvail().x - 2 * kGap) / 3);
  for (size_t i = 0; i < kFormats.size(); ++i) {
    if (i > 0) ImGui::SameLine();
    if (kit::button(kFormats[i], choice.formats[i] ? kit::Weight::chief : kit::Weight::plain, each)) choice.formats[i] = !choice.formats[i];
  }
  static constexpr std::array<std::string_view, 3> kWhat{"What is visible", "Every piece", "Selected"};
  kit::dimText("What");
  kit::segmented("what", kWhat, choice.what);
  kit::dimText("Name and folder");
  bool asked = kit::textField("##name", choice.name, 0, "Name without ending", ImGui::IsWindowAppearing()) && ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Enter), false);
  kit::textField("##folder", choice.folder, ImGui::GetContentRegionAvail().x - kRow - kGap, "Folder");
  ImGui::SameLine();
  if (kit::iconButton("folders", "folder", kRow, kit::Lit::off, "Choose a folder", "", "", false)) {
    openFiles(memory, "Choose a folder", "Choose", {}, choice.folder);
    memory.filesFor = FilesFor::folder;
  }
  if (memory.filesFor == FilesFor::folder && memory.files.draw()) choice.folder = memory.files.path().string();

  engine::ExportOptions options;
  options.visibleOnly = choice.what == 0;
  options.piece = choice.what == 2 ? context.state.selected : 0;
  std::vector<std::string> existing;
  for (size_t i = 0; i < kEndings.size(); ++i) {
    if (!choice.formats[i]) continue;
    options.files.push_back(fs::path(choice.folder) / (choice.name + std::string(kEndings[i])));
    if (fs::exists(options.files.back(), ignored)) existing.push_back(options.files.back().filename().string());
  }
  std::string problem;
  if (choice.name.empty() || choice.name.find('/') != std::string::npos) problem = "A name is needed, without a slash.";
  else if (!fs::is_directory(choice.folder, ignored)) problem = "There is no folder " + choice.folder;
  else if (options.files.empty()) problem = "Choose a format.";
  else if (choice.what == 2 && !context.now.document->piece(options.piece)) problem = "No piece of clay is selected.";
  else if (context.now.document->pieces.empty()) problem = "There is no clay to export.";
  if (!problem.empty()) kit::wrapped(problem, colours().warning);

  const bool asking = !choice.existing.empty() && choice.existing == existing;
  if (asking) {
    std::string names;
    for (const std::string& name : existing) names += (names.empty() ? "" : ", ") + name;
    kit::wrapped(names + (existing.size() == 1 ? " is there already: write over it?" : " are there already: write over them?"), colours().warning);
  } else {
    choice.existing.clear();
  }
  kit::gap(6);
  const std::string_view verb = asking ? "Write over" : "Export";
  const float wide = 110;
  ImGui::SetCursorPosX(ImGui::GetWindowWidth() - 18 - 2 * wide - kGap);
  if (kit::button("Cancel", kit::Weight::plain, wide)) open = false;
  ImGui::SameLine();
  ImGui::BeginDisabled(!problem.empty());
  asked |= kit::button(verb, asking ? kit::Weight::danger : kit::Weight::chief, wide);
  ImGui::EndDisabled();
  if (asked && problem.empty()) {
    if (!existing.empty() && !asking) {
      choice.existing = existing;
    } else {
      context.bench.exportTo(options);
      open = false;
    }
  }
  if (!open) choice.existing.clear();
  kit::endDialog(open);
}

void drawNewClay(Context& context, Memory& memory) {
  if (!kit::beginDialog("New clay", "Add clay", 380, 0, &memory.newClayOpen)) return;
  NewClay& clay = memory.newClay;
  static constexpr std::array<std::string_view, 2> kShapes{"Block", "Ball"};
  kit::segmented("shape", kShapes, clay.shape);
  const auto length = [](std::string_view id, std::string_view name, double& value, double low, double standard) {
    kit::number({id, name, "", "mm", low, 1000, standard, true}, value);
  };
  double voxels = 0;
  if (clay.shape == 0) {
    length("x", "Width", clay.xMm, 1, 60);
    length("y", "Depth", clay.yMm, 1, 60);
    length("z", "Height", clay.zMm, 1, 40);
    const double most = 0.5 * std::min({clay.xMm, clay.yMm, clay.zMm});
    clay.roundMm = std::min(clay.roundMm, most);
    kit::number({"round", "Rounding of edges", "", "mm", 0, most, std::min(4.0, most)}, clay.roundMm);
    voxels = 2 * (clay.xMm * clay.yMm + clay.yMm * clay.zMm + clay.zMm * clay.xMm) / (clay.voxelMm * clay.voxelMm);
  } else {
    length("radius", "Radius", clay.radiusMm, 0.5, 30);
    voxels = 4 * 3.14159265358979 * clay.radiusMm * clay.radiusMm / (clay.voxelMm * clay.voxelMm);
  }
  kit::number({"voxel", "Voxel", "Finer shows more and costs more.", "mm", 0.01, 10, 0.5, true}, clay.voxelMm);
  // Two triangles a voxel of the surface; a half more on average for how a curved surface crosses them.
  kit::fact("Triangles, about", kit::counted(uint64_t(std::round(3 * voxels / 1000)) * 1000));
  kit::gap(6);
  ImGui::SetCursorPosX(ImGui::GetWindowWidth() - 18 - 2 * 96 - kGap);
  if (kit::button("Cancel", kit::Weight::plain, 96)) memory.newClayOpen = false;
  ImGui::SameLine();
  if (kit::button("Add", kit::Weight::chief, 96)) {
    if (clay.shape == 0) context.bench.addBlock(Vec3d(clay.xMm, clay.yMm, clay.zMm), clay.roundMm, clay.voxelMm);
    else context.bench.addSphere(clay.radiusMm, clay.voxelMm);
    memory.newClayOpen = false;
    context.state.shown.firstStart = false;
  }
  kit::endDialog(memory.newClayOpen);
}

void drawPreferences(Context& context, Memory&) {
  bool& open = context.state.shown.preferences;
  if (!kit::beginDialog("Preferences", "Preferences", 400, 0, &open)) return;
  static constexpr std::array<std::string_view, 2> kThemes{"Dark", "Light"};
  kit::dimText("Theme");
  int theme = int(context.state.theme);
  if (kit::segmented("theme", kThemes, theme)) runAction(context, "window.theme");
  static constexpr std::array<std::string_view, 8> kScales{"As the display says", "75 %", "100 %", "125 %", "150 %", "200 %", "250 %", "300 %"};
  static constexpr std::array<float, 8> kFactors{0, 0.75f, 1, 1.25f, 1.5f, 2, 2.5f, 3};
  int scale = int(std::find(kFactors.begin(), kFactors.end(), context.state.interfaceScale) - kFactors.begin());
  if (kit::choice("Size", kScales, scale, "Of everything flat.")) context.state.interfaceScale = kFactors[size_t(scale)];
  kit::toggle("Snap widgets", context.state.snapWidgets, "Dragged widgets snap to guides, clay and grid.");
  kit::toggle("Light background", context.state.look.lightBackground, "Behind the clay.");
  kit::gap(6);
  if (kit::button("Keys…", kit::Weight::plain, -1)) {
    open = false;
    context.state.shown.shortcuts = true;
  }
  kit::endDialog(open);
}

void drawFirstStart(Context& context, Memory& memory) {
  const kit::Rect& free = memory.layout.free;
  const engine::Document& document = *context.now.document;
  const bool empty = document.pieces.empty() && document.parts.empty() && document.guides.empty();
  if (!context.state.shown.firstStart || free.width() < 200) return;
  const bool room = free.height() > 420;
  kit::beginCard("First start", {std::floor((free.left + free.right) / 2), std::floor(free.top + (room ? 0.14f : 0.02f) * free.height())}, {0.5f, 0},
                 std::min(440.0f, free.width() - 24), free.height() - 110);
  ImGui::PushFont(fonts().title);
  kit::text("Argil");
  ImGui::PopFont();
  ImGui::SameLine(ImGui::GetWindowWidth() - kPad - 22);
  if (kit::iconButton("close", "close", 22, kit::Lit::off, "Close; it is in the Help menu")) context.state.shown.firstStart = false;
  kit::wrapped("Digital clay that you touch.", colours().dim);
  kit::gap(8);
  if (bigButton("block", "A block to carve", "60 × 60 × 40 mm, and the tool in hand")) runAction(context, "clay.block");
  if (bigButton("folder", "Open a file", "A mesh becomes clay: STL, OBJ, PLY, OFF")) runAction(context, "file.open");
  if (bigButton("keys", "A tour of the keys", "What mouse, pen and keyboard do")) context.state.shown.shortcuts = true;
  if (!context.state.recentFiles.empty() && room) {
    kit::gap(6);
    kit::dimText("Opened before");
    for (size_t i = 0; i < std::min<size_t>(3, context.state.recentFiles.size()); ++i) {
      const std::string file = context.state.recentFiles[i];
      ImGui::PushID(int(i));
      const float width = ImGui::GetContentRegionAvail().x;
      if (ImGui::InvisibleButton("recent", {width, 24})) {
        beginDocument(context, memory, file);
      }
      const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
      if (ImGui::IsItemHovered()) ImGui::GetWindowDrawList()->AddRectFilled(a, b, colours().fieldHover, kRound);
      const ImVec2 after = ImGui::GetCursorPos();
      ImGui::SetCursorScreenPos({a.x + 6, a.y + 3});
      kit::elided(fs::path(file).filename().string() + "   " + fs::path(file).parent_path().string(), width - 12, colours().text);
      ImGui::SetCursorPos(after);
      ImGui::PopID();
    }
  }
  kit::endCard();
  if (!empty && !memory.firstStartSeen) context.state.shown.firstStart = false;  // Began with a document.
  memory.firstStartSeen = true;
}

}  // namespace argil::studio
