// The page that a start without a file shows: new clay, a file, what was opened before as pictures, what can be
// recovered, examples.

#include <imgui_internal.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "engine/saving/thumbnail.h"
#include "engine/session/tool_demo.h"
#include "engine/text/script.h"
#include "io/models/picture.h"
#include "ui3d/studio/files/settings.h"
#include "ui3d/studio/kit/icons.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace fs = std::filesystem;
namespace {

constexpr size_t kMostRecent = 6;
constexpr int kMostEdge = 1024;           // Pixels of a document's picture: ours have 256.
constexpr uint32_t kFirstTexture = 1000;  // Of the renderer's pictures for panels.
constexpr float kTile = 62, kPictureTile = 112, kRowTile = 40, kLeastTile = 150;
constexpr std::array<std::string_view, 3> kExamples{"carve", "wax", "twist"};

struct Item {
  std::string section, id, name, help;
  std::string_view icon;
  int texture = -1;  // Of StartPage::pictures.
  float height = kTile;
  std::function<void()> run;
};

// The pictures of documents, read beside the person: a disk may be slow.
void readPictures(const Context& context, StartPage& page) {
  std::vector<std::string> files(
      context.state.recentFiles.begin(),
      context.state.recentFiles.begin() + std::ptrdiff_t(std::min(kMostRecent, context.state.recentFiles.size())));
  if (files != page.files) {
    page.files = files;
    page.pictures = std::make_shared<std::vector<render::Image>>(files.size());
    page.sent = false;
    page.reading = std::make_unique<engine::BackgroundJob>([files, pictures = page.pictures](Job& job) {
      for (size_t i = 0; i < files.size() && !job.cancelled(); ++i) {
        try {
          if (fs::path(files[i]).extension() != ".argil") continue;
          const std::vector<std::byte> png = engine::thumbnailOf(files[i]);
          if (png.empty()) continue;
          io::ColourImage picture = io::unpackPicture(png, kMostEdge, &job);
          (*pictures)[i] = {picture.width, picture.height, std::move(picture.rgba)};
        } catch (const Error&) {
          // An icon stands for it; opening it says what is wrong.
        }
      }
    });
  }
}

// A script of the tool's scene, as a file that can be looked at too.
void openExample(Context& context, Memory& memory, std::string_view id) {
  const engine::ToolRow* row = engine::findTool(id);
  const fs::path settings = settingsFile();
  if (!row || settings.empty()) return;
  const fs::path folder = settings.parent_path() / "examples";
  std::error_code failed;
  fs::create_directories(folder, failed);
  const fs::path file = folder / (std::string(row->name) + ".json");
  try {
    engine::writeScript(file, engine::toolDemo(*row));
  } catch (const Error& error) {
    context.bench.tell(engine::Message::Level::error, error.what());
    return;
  }
  beginDocument(context, memory, file);
}

std::vector<Item> itemsOf(Context& context, Memory& memory) {
  std::vector<Item> items;
  const auto action = [&](const char* section, const char* name, const char* help, std::string_view icon,
                          const char* id) {
    items.push_back({section, id, name, help, icon, -1, kTile, [&context, id] { runAction(context, id); }});
  };
  action("New", "A block", "60 × 60 × 40 mm", "block", "clay.block");
  action("New", "A ball", "60 mm across", "sphere", "clay.sphere");
  action("New", "Open…", "A document or a model", "folder", "file.open");
  if (const Action* recover = findAction("file.recover"); recover->enabled(context))
    action("New", "Recover…", "Work that was not saved", "history", "file.recover");
  const std::vector<std::string>& recent = context.state.recentFiles;
  for (size_t i = 0; i < std::min(kMostRecent, recent.size()); ++i) {
    const fs::path file = recent[i];
    std::error_code ignored;
    if (!fs::is_regular_file(file, ignored)) continue;
    const bool pictured =
        memory.start.sent && i < memory.start.pictures->size() && (*memory.start.pictures)[i].width > 0;
    items.push_back({"Opened before", recent[i], file.filename().string(), file.parent_path().string(), "file",
                     pictured ? int(i) : -1, kPictureTile,
                     [&context, &memory, file] { beginDocument(context, memory, file); }});
  }
  for (const std::string_view id : kExamples) {
    const engine::ToolRow* row = engine::findTool(id);
    if (row)
      items.push_back({"Examples", "example." + std::string(id), std::string(row->name), "",
                       hasIcon(id) ? id : row->icon, -1, kRowTile,
                       [&context, &memory, id] { openExample(context, memory, id); }});
  }
  return items;
}

// Draws one; true when it was clicked. `rect`: where it stands.
bool tile(const Item& item, const StartPage& page, float width, bool chosen, ImRect& rect) {
  ImGui::PushID(item.id.c_str());
  const bool pressed = ImGui::InvisibleButton("tile", {width, item.height});
  ImGui::PopID();
  const bool hovered = ImGui::IsItemHovered();
  const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
  rect = {a, b};
  ImDrawList& list = *ImGui::GetWindowDrawList();
  const Colours& c = colours();
  list.AddRectFilled(a, b, hovered || chosen ? c.fieldHover : c.field, 7);
  list.AddRect(a, b, hovered || chosen ? c.accent : c.line, 7, 0, chosen ? 2.0f : 1.0f);
  const float line = ImGui::GetTextLineHeight();
  ImVec2 words{a.x + 50, std::floor((a.y + b.y) / 2 - (item.help.empty() ? line / 2 : line + 1))};
  float room = b.x - words.x - 8;
  if (item.height == kPictureTile) {
    words = {a.x + 10, b.y - 2 * line - 6};
    room = b.x - a.x - 20;
    const ImRect frame{a.x + 5, a.y + 5, b.x - 5, words.y - 4};
    if (item.texture >= 0) {
      // As large as it fits, what is beyond cut off evenly.
      const render::Image& image = (*page.pictures)[size_t(item.texture)];
      const float wanted = frame.GetWidth() / frame.GetHeight(), own = float(image.width) / float(image.height);
      const float u = wanted < own ? (1 - wanted / own) / 2 : 0, v = wanted > own ? (1 - own / wanted) / 2 : 0;
      const auto texture = reinterpret_cast<ImTextureID>(uintptr_t(kFirstTexture + uint32_t(item.texture)));
      list.AddImage(texture, frame.Min, frame.Max, {u, v}, {1 - u, 1 - v});
    } else {
      drawIcon(list, item.icon, frame.GetCenter(), 30, c.dim);
    }
  } else {
    drawIcon(list, item.icon, {a.x + 26, (a.y + b.y) / 2}, 24, c.accent);
  }
  ImGui::SetCursorScreenPos(words);
  ImGui::PushFont(fonts().strong);
  kit::elided(item.name, room, c.text);
  ImGui::PopFont();
  if (!item.help.empty()) {
    ImGui::SetCursorScreenPos({words.x, words.y + line + 1});
    kit::elided(item.help, room, c.dim);
  }
  return pressed;
}

// The tile that lies next in a direction; `from` itself where there is none.
int nextTile(const std::vector<ImRect>& rects, int from, int dx, int dy) {
  if (rects.empty()) return -1;
  if (from < 0) return 0;
  int best = from;
  float nearest = std::numeric_limits<float>::max();
  const ImVec2 here = rects[size_t(from)].GetCenter();
  for (int i = 0; i < int(rects.size()); ++i) {
    const ImVec2 there = rects[size_t(i)].GetCenter();
    const float x = there.x - here.x, y = there.y - here.y, along = x * float(dx) + y * float(dy),
                across = std::abs(dx != 0 ? y : x);
    // In rows nothing of another row is beside.
    if (i == from || along < 4 || (dx != 0 && across > 20)) continue;
    if (const float away = along + 0.5f * across; away < nearest) nearest = away, best = i;
  }
  return best;
}

}  // namespace

std::vector<std::pair<uint32_t, const render::Image*>> takePictures(StartPage& page) {
  std::vector<std::pair<uint32_t, const render::Image*>> pictures;
  if (!page.reading || !page.reading->done() || page.sent) return pictures;
  for (size_t i = 0; i < page.pictures->size(); ++i)
    if (const render::Image& image = (*page.pictures)[i]; image.width > 0)
      pictures.emplace_back(kFirstTexture + uint32_t(i), &image);
  page.sent = true;
  return pictures;
}

void drawFirstStart(Context& context, Memory& memory) {
  const engine::Document& document = *context.now.document;
  const bool empty = document.pieces.empty() && document.parts.empty() && document.guides.empty();
  StartPage& page = memory.start;
  bool& open = context.state.shown.firstStart;
  // Gone as soon as work begins, also work that came with the start; asked for later it stays.
  if (open && !empty && page.wasEmpty) open = false;
  page.wasEmpty = empty;
  const kit::Rect& free = memory.layout.clear;
  if (!open || free.width() < 200) {
    page.chosen = -1;
    return;
  }
  readPictures(context, page);
  memory.moves |= !page.sent;
  const std::vector<Item> items = itemsOf(context, memory);

  // Messages stand below it.
  const float width = std::min(640.0f, free.width() - 24), height = free.height() - memory.noticesHeight,
              air = std::min(40.0f, 0.06f * height);
  if (height < 60) return;
  kit::beginCard("First start", {std::floor((free.left + free.right) / 2), std::floor(free.top + air)}, {0.5f, 0},
                 width, std::floor(height - 2 * air));
  ImGui::PushFont(fonts().title);
  kit::text("Argil");
  ImGui::PopFont();
  ImGui::SameLine(ImGui::GetWindowWidth() - kPad - 22 - ImGui::GetCurrentWindow()->ScrollbarSizes.x);
  if (kit::iconButton("close", "close", 22, kit::Lit::off, "Close; it is in the Help menu", "Escape")) open = false;

  std::vector<ImRect> rects;
  const Item* chosen = nullptr;
  std::string section;
  const float room = ImGui::GetContentRegionAvail().x;
  int column = 0, columns = 1;
  ImVec2 at = ImGui::GetCursorScreenPos();
  for (size_t i = 0; i < items.size(); ++i) {
    const Item& item = items[i];
    if (item.section != section) {
      section = item.section;
      if (i > 0) {
        ImGui::SetCursorScreenPos({at.x, at.y + items[i - 1].height + kGap});
        kit::gap(4);
      }
      kit::dimText(section);
      const int count =
          int(std::count_if(items.begin(), items.end(), [&](const Item& each) { return each.section == section; }));
      columns = std::clamp(int((room + kGap) / (kLeastTile - 20 + kGap)), 1, std::min(4, std::max(count, 3)));
      column = 0;
      at = ImGui::GetCursorScreenPos();
    } else if (++column == columns) {
      column = 0;
      at.y += item.height + kGap;
    }
    const float wide = std::floor((room - kGap * float(columns - 1)) / float(columns));
    ImGui::SetCursorScreenPos({at.x + float(column) * (wide + kGap), at.y});
    const bool mine = page.chosen == int(i);
    if (mine && page.moved) ImGui::SetScrollHereY(0.2f);
    rects.emplace_back();
    if (tile(item, page, wide, mine, rects.back())) chosen = &item;
  }
  ImGui::SetCursorScreenPos({at.x, at.y + items.back().height + kGap});
  kit::gap(4);
  kit::toggle("Show this page when Argil starts", context.state.startPage);
  kit::endCard();

  // By keys, while nothing else is open and nothing is being typed.
  page.moved = false;
  const ImGuiContext& g = *GImGui;
  if (g.OpenPopupStack.empty() && !ImGui::GetIO().WantTextInput && !ImGui::GetIO().KeyCtrl && !ImGui::GetIO().KeyAlt) {
    const auto pressed = [](ImGuiKey key, bool again = true) {
      return ImGui::IsKeyPressed(ImGui::GetKeyIndex(key), again);
    };
    int next = page.chosen;
    if (pressed(ImGuiKey_Tab))
      next = (std::max(next, -1) + (ImGui::GetIO().KeyShift ? int(items.size()) - (next < 0 ? 0 : 1) : 1)) %
             int(items.size());
    if (pressed(ImGuiKey_RightArrow)) next = nextTile(rects, next, 1, 0);
    if (pressed(ImGuiKey_LeftArrow)) next = nextTile(rects, next, -1, 0);
    if (pressed(ImGuiKey_DownArrow)) next = nextTile(rects, next, 0, 1);
    if (pressed(ImGuiKey_UpArrow)) next = nextTile(rects, next, 0, -1);
    page.moved = next != page.chosen;
    page.chosen = std::min(next, int(items.size()) - 1);
    memory.moves |= page.moved;
    if (page.chosen >= 0 && (pressed(ImGuiKey_Enter, false) || pressed(ImGuiKey_KeyPadEnter, false)))
      chosen = &items[size_t(page.chosen)];
    if (pressed(ImGuiKey_Escape, false) && !kit::escapeIsTaken()) open = false;
  }
  if (chosen) chosen->run();
}

}  // namespace argil::studio
