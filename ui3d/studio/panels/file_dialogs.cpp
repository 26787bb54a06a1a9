// Opening, importing, saving: where the file is and what is to be known of it.

#include <algorithm>
#include <cmath>
#include <utility>

#include "ui3d/studio/kit/icons.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace fs = std::filesystem;
namespace {

constexpr int k4kPixels = 3840;

void openFiles(Context& context, Memory& memory, FilesFor what, FileDialog::Request request) {
  if (request.where.empty()) request.where = context.state.lastFolder;
  memory.files.open(std::move(request));
  memory.filesFor = what;
}

// A name for a file, from what is in the document.
std::string proposedName(const Context& context) {
  if (!context.now.file.path.empty()) return context.now.file.path.stem().string();
  if (!context.now.file.name.empty()) return fs::path(context.now.file.name).stem().string() + " recovered";
  const auto& pieces = context.now.document->pieces;
  std::string name = pieces.empty() ? std::string() : pieces.front().name;
  std::replace(name.begin(), name.end(), '/', '-');
  return name.empty() ? "clay" : name;
}

void save(Context& context, Memory& memory) {
  if (context.now.file.path.empty())
    openSaveAs(context, memory);
  else
    context.state.wishes.save = fs::path();
}

}  // namespace

void openSaveAs(Context& context, Memory& memory, const std::string& why) {
  const fs::path& path = context.now.file.path;
  openFiles(context, memory, FilesFor::save,
            {"Save the document",
             "Save",
             {".argil"},
             path.empty() ? std::string() : path.parent_path().string(),
             true,
             proposedName(context) + ".argil",
             why});
}

void serveWishes(Context& context, Memory& memory) {
  // A save into its own file failed: the message says why, and here another name can be given. Who is asked about
  // leaving is offered it there.
  const uint64_t refused = context.now.file.refused;
  if (std::exchange(memory.refusedSeen, refused) < refused && memory.keep.stage() == SaveFlow::Stage::idle)
    openSaveAs(context, memory, context.now.file.refusal);
  if (std::exchange(context.state.quit, false)) depart(context, memory, {Departure::To::quit});
  if (const auto file = std::exchange(context.state.wishes.open, std::nullopt)) beginDocument(context, memory, *file);
  const std::string wish = std::exchange(context.state.wishes.dialog, {});
  if (wish == "new") {
    depart(context, memory, {Departure::To::newDocument});
  } else if (wish == "open") {
    openFiles(context, memory, FilesFor::open, {"Open a document", "Open", endingsToOpen(), {}});
  } else if (wish == "recent") {
    memory.recentOpen = true;
  } else if (wish == "save") {
    save(context, memory);
  } else if (wish == "saveAs") {
    openSaveAs(context, memory);
  } else if (wish == "saveCopy") {
    openFiles(context, memory, FilesFor::copy,
              {"Save a copy without history", "Save", {".argil"}, {}, true, proposedName(context) + " copy.argil"});
  } else if (wish == "import" || wish == "part") {
    memory.importAsPart = wish == "part";
    openFiles(context, memory, FilesFor::import, {"Import a model", "Import", endingsToImport(), {}});
  } else if (wish == "picture") {
    openFiles(context, memory, FilesFor::picture,
              {"Save a picture of the view", "Save", {".png"}, {}, true, proposedName(context) + ".png"});
  } else if (wish == "recover") {
    memory.recoverOpen = true;
  } else if (wish == "clay") {
    memory.newClay.fit(*context.now.document);
    memory.newClayOpen = true;
  } else if (wish == "toolFile") {
    const engine::ToolRow* row = engine::findTool(context.state.toolId);
    if (!row || row->file == engine::ToolFile::none) return;
    const fs::path now = context.state.tool().file;
    const bool image = row->file == engine::ToolFile::image;
    openFiles(context, memory, FilesFor::toolFile,
              {image ? "Choose an image" : "Choose a shape", "Choose", image ? endingsOfImages() : endingsToImport(),
               now.empty() ? std::string() : now.parent_path().string()});
  } else if (wish.starts_with("piece.")) {
    beginOperation(context, memory, std::string_view(wish).substr(6));
  } else if (wish.starts_with("export")) {
    if (wish.size() > 6) memory.exporting.endings = {wish.substr(6)};
    // A name that was typed stays for its document.
    ExportChoice& exporting = memory.exporting;
    if (exporting.name.empty() || exporting.name == exporting.proposed || exporting.of != context.now.file.opened)
      exporting.name = proposedName(context);
    exporting.proposed = proposedName(context);
    exporting.of = context.now.file.opened;
    context.state.shown.exporting = true;
  }
}

void drawFiles(Context& context, Memory& memory) {
  FileDialog& files = memory.files;
  StudioState& state = context.state;
  switch (memory.filesFor) {
    case FilesFor::none:
    case FilesFor::folder:
      return;  // Drawn within the export.
    case FilesFor::open:
      if (files.draw()) beginDocument(context, memory, files.path());
      break;
    case FilesFor::import:
      if (files.draw()) askModel(memory, files.path(), false, memory.importAsPart);
      break;
    case FilesFor::save:
      if (files.draw()) {
        state.wishes.save = files.path();
        memory.keep.named();
      } else if (!files.isOpen()) {
        memory.keep.notNamed();
      }
      break;
    case FilesFor::locate:
      if (files.draw()) {
        Departure departure{.to = Departure::To::recovered, .what = memory.located};
        departure.how.base = files.path();
        depart(context, memory, std::move(departure));
      }
      break;
    case FilesFor::copy:
      if (files.draw()) {
        state.wishes.copy = files.path();
        state.lastFolder = files.path().parent_path().string();
      }
      break;
    case FilesFor::toolFile:
      if (files.draw()) {
        state.tool().file = files.path().string();
        state.lastFolder = files.path().parent_path().string();
      }
      break;
    case FilesFor::picture:
      if (files.draw(
              [&] {
                static constexpr std::array<std::string_view, 2> kSizes{"As large as the view", "4K: 3840 pixels wide"};
                kit::segmented("size", kSizes, memory.pictureSize);
              },
              kRow + kGap)) {
        state.wishes.picture = PictureWish{files.path(), memory.pictureSize == 1 ? k4kPixels : 0};
        state.lastFolder = files.path().parent_path().string();
      }
      break;
  }
  if (!files.isOpen()) memory.filesFor = FilesFor::none;
}

namespace {

// From one file that is there to the next one, up (−1) or down (+1); where there is none it stays.
int nextThere(const std::vector<bool>& present, int from, int step) {
  for (int i = from + step; step != 0 && i >= 0 && i < int(present.size()); i += step)
    if (present[size_t(i)]) return i;
  return from;
}

}  // namespace

void drawRecent(Context& context, Memory& memory) {
  if (!kit::beginDialog("Recent", "Open recent", 560, 0, &memory.recentOpen)) return;
  std::vector<std::string>& recent = context.state.recentFiles;
  if (recent.empty()) kit::wrapped("No file was opened or saved yet.", colours().dim);
  std::string chosen;
  std::vector<bool> present;
  for (const std::string& file : recent) {
    std::error_code ignored;
    present.push_back(fs::is_regular_file(file, ignored));
  }
  int& marked = memory.recentMarked;
  if (ImGui::IsWindowAppearing())
    marked = int(std::find(present.begin(), present.end(), true) - present.begin());
  else
    marked = nextThere(present, marked, kit::arrowStep());
  for (size_t i = 0; i < recent.size(); ++i) {
    const fs::path file = recent[i];
    const bool there = present[i];
    ImGui::PushID(int(i));
    const float width = ImGui::GetContentRegionAvail().x;
    ImGui::BeginDisabled(!there);
    if (ImGui::InvisibleButton("recent", {width, 28})) chosen = recent[i];
    ImGui::EndDisabled();
    const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
    ImDrawList& list = *ImGui::GetWindowDrawList();
    const Colours& c = colours();
    if (there && (ImGui::IsItemHovered() || marked == int(i)))
      list.AddRectFilled(a, b, marked == int(i) ? c.soft : c.fieldHover, kRound);
    drawIcon(list, "file", {a.x + 15, (a.y + b.y) / 2}, 17, there ? c.accent : c.dim);
    const ImVec2 after = ImGui::GetCursorPos();
    const std::string name = file.filename().string();
    const float named = std::min(ImGui::CalcTextSize(name.c_str()).x, 0.5f * width),
                y = std::floor((a.y + b.y - ImGui::GetTextLineHeight()) / 2);
    ImGui::SetCursorScreenPos({a.x + 30, y});
    kit::elided(name, named, there ? c.text : c.dim);
    ImGui::SetCursorScreenPos({a.x + 30 + named + 14, y});
    kit::elided(there ? file.parent_path().string() : "no longer there: " + file.parent_path().string(),
                width - named - 54, c.dim);
    ImGui::SetCursorPos(after);
    ImGui::PopID();
  }
  kit::gap(8);
  const float clear = kit::buttonWidth("Clear list");
  ImGui::SetCursorPosX(ImGui::GetWindowWidth() - 18 - 2 * 96 - clear - 2 * kGap);
  ImGui::BeginDisabled(recent.empty());
  if (kit::button("Clear list", kit::Weight::plain, clear)) recent.clear();
  ImGui::EndDisabled();
  ImGui::SameLine();
  if (kit::button("Cancel", kit::Weight::plain, 96)) memory.recentOpen = false;
  ImGui::SameLine();
  const bool has = size_t(marked) < recent.size() && present[size_t(marked)];
  ImGui::BeginDisabled(!has);
  if (kit::mainButton("Open", 96) && has) chosen = recent[size_t(marked)];
  ImGui::EndDisabled();
  const bool open = chosen.empty() && memory.recentOpen;
  memory.recentOpen = open;
  kit::endDialog(open);
  if (!chosen.empty()) beginDocument(context, memory, chosen);
}

}  // namespace argil::studio
