#include "ui3d/studio/kit/file_dialog.h"

#include <imgui_internal.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <cstdlib>

#include "ui3d/studio/kit/icons.h"
#include "ui3d/studio/kit/kit.h"
#include "ui3d/studio/kit/theme.h"

namespace argil::studio {
namespace fs = std::filesystem;
namespace {

// More than a person looks through; a folder of millions must not stop the window for long.
constexpr size_t kMostEntries = 4000;

std::string home() {
  const char* folder = std::getenv("HOME");
  return folder && *folder ? folder : "/";
}

// What a person typed, as a path: "~" is the home, others begin in `folder`.
fs::path meant(const std::string& typed, const fs::path& folder) {
  if (typed == "~") return home();
  if (typed.starts_with("~/")) return fs::path(home()) / typed.substr(2);
  return folder / typed;  // An absolute one stays itself.
}

std::string small(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return text;
}

}  // namespace

void FileDialog::open(Request request) {
  request_ = std::move(request);
  open_ = true;
  typed_ = request_.name;
  problem_.clear();
  replacing_.clear();
  std::error_code ignored;
  fs::path where = request_.where.empty() ? folder_ : meant(request_.where, fs::path(home()));
  if (where.empty() || !fs::is_directory(where, ignored)) where = home();
  go(where);
}

void FileDialog::go(const fs::path& folder) {
  std::error_code error;
  const fs::path whole = fs::canonical(folder, error);
  if (error || !fs::is_directory(whole, error)) {
    problem_ = "There is no folder " + folder.string();
    return;
  }
  folder_ = whole;
  folderText_ = whole.string();
  problem_.clear();
  list();
}

void FileDialog::list() {
  entries_.clear();
  chosen_ = -1;
  marked_ = false;
  std::error_code error;
  fs::directory_iterator at(folder_, fs::directory_options::skip_permission_denied, error), end;
  if (error) problem_ = "This folder cannot be read: " + error.message();
  for (; !error && at != end && entries_.size() < kMostEntries; at.increment(error)) {
    Entry entry;
    entry.name = at->path().filename().string();
    std::error_code ignored;
    entry.folder = at->is_directory(ignored);
    if (entry.name.empty() || entry.name[0] == '.') continue;
    if (!entry.folder) {
      const std::string ending = small(at->path().extension().string());
      if (std::find(request_.endings.begin(), request_.endings.end(), ending) == request_.endings.end()) continue;
      entry.bytes = at->file_size(ignored);
      if (ignored) entry.bytes = 0;
    }
    entries_.push_back(std::move(entry));
  }
  std::sort(entries_.begin(), entries_.end(), [](const Entry& a, const Entry& b) {
    return a.folder != b.folder ? a.folder : small(a.name) < small(b.name);
  });
}

// Where a file is to be written: true when it may be.
bool FileDialog::writes(fs::path whole) {
  if (std::find(request_.endings.begin(), request_.endings.end(), small(whole.extension().string())) ==
      request_.endings.end())
    whole += request_.endings.front();
  std::error_code ignored;
  if (!fs::is_directory(whole.parent_path(), ignored)) {
    problem_ = "There is no folder " + whole.parent_path().string();
    return false;
  }
  if (fs::exists(whole, ignored) && replacing_ != whole) {
    replacing_ = whole;
    return false;
  }
  path_ = whole;
  return true;
}

bool FileDialog::chooses(const std::string& typed) {
  const fs::path whole = meant(typed, folder_);
  std::error_code ignored;
  problem_.clear();
  if (fs::is_directory(whole, ignored) && !(request_.endings.empty() && typed.empty())) {
    go(whole);
    // The name of what is to be written goes along from folder to folder.
    if (!request_.toWrite)
      typed_.clear();
    else if (typed_ == typed)
      typed_ = request_.name;
    return false;
  }
  if (request_.endings.empty()) {
    path_ = folder_;
    return true;
  }
  if (request_.toWrite) return writes(whole);
  if (!fs::is_regular_file(whole, ignored)) {
    problem_ = "There is no file " + whole.string();
    return false;
  }
  path_ = whole;
  return true;
}

// Arrows go through the list; Enter then opens the entry that is marked, as a double click does.
int FileDialog::moveMark() {
  const int step = entries_.empty() || ImGui::IsWindowAppearing() ? 0 : kit::arrowStep();
  if (step == 0) return 0;
  ImGui::ClearActiveID();  // Else the field would keep its own text, and Enter with it.
  chosen_ =
      chosen_ < 0 ? (step > 0 ? 0 : int(entries_.size()) - 1) : std::clamp(chosen_ + step, 0, int(entries_.size()) - 1);
  marked_ = true;
  if (!entries_[size_t(chosen_)].folder) typed_ = entries_[size_t(chosen_)].name;
  return step;
}

bool FileDialog::draw(const std::function<void()>& more, float moreHeight) {
  const bool folders = request_.endings.empty();
  if (!kit::beginDialog("Files", request_.title.c_str(), 640, 560, &open_)) return false;
  bool done = false;
  const int step = moveMark();
  if (!request_.note.empty()) kit::wrapped(request_.note, colours().warning);
  if (kit::iconButton("up", "up", kRow, kit::Lit::off, "The folder above", "", "", false)) go(folder_.parent_path());
  ImGui::SameLine();
  if (kit::iconButton("home", "home", kRow, kit::Lit::off, "Home folder", "", "", false)) go(home());
  ImGui::SameLine();
  if (kit::textField("##folder", folderText_, 0, "Folder")) go(meant(folderText_, folder_));

  // Another name, another question.
  if (!replacing_.empty() && replacing_ != meant(typed_, folder_) &&
      replacing_ != meant(typed_ + request_.endings.front(), folder_))
    replacing_.clear();
  const bool replaces = !replacing_.empty();
  const float lines = (problem_.empty() ? 0.0f : 1.0f) + (replaces ? 1.0f : 0.0f);
  const float foot = kRow + lines * ImGui::GetTextLineHeightWithSpacing() +
                     (folders ? 0 : ImGui::GetFrameHeightWithSpacing()) + moreHeight;
  ImGui::PushStyleColor(ImGuiCol_ChildBg, colours().bar);
  ImGui::PushStyleVar(ImGuiStyleVar_WindowPadding, {6, 6});
  ImGui::BeginChild("list", {0, ImGui::GetContentRegionAvail().y - foot - kGap}, true,
                    ImGuiWindowFlags_AlwaysUseWindowPadding);
  ImGui::PopStyleVar();
  ImGui::PopStyleColor();
  kit::sharpen(*ImGui::GetWindowDrawList());
  ImGui::PushStyleVar(ImGuiStyleVar_ItemSpacing, {0, 0});
  constexpr float kHeight = 27;
  int opened = -1;
  if (entries_.empty())
    kit::dimText(folders            ? "No folders in here."
                 : request_.toWrite ? "No files of this kind in here."
                                    : "Nothing in here that can be opened.");
  ImGuiListClipper clipper;
  clipper.Begin(int(entries_.size()), kHeight);
  while (clipper.Step()) {
    for (int i = clipper.DisplayStart; i < clipper.DisplayEnd; ++i) {
      const Entry& entry = entries_[size_t(i)];
      ImGui::PushID(i);
      const float width = ImGui::GetContentRegionAvail().x;
      if (ImGui::InvisibleButton("entry", {width, kHeight})) {
        chosen_ = i;
        marked_ = false;
        if (!entry.folder) typed_ = entry.name;
      }
      const bool hovered = ImGui::IsItemHovered();
      if (hovered && ImGui::IsMouseDoubleClicked(0)) opened = i;
      const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
      ImDrawList& draw = *ImGui::GetWindowDrawList();
      const Colours& c = colours();
      if (chosen_ == i || hovered) draw.AddRectFilled(a, b, chosen_ == i ? c.soft : c.fieldHover, kRound);
      drawIcon(draw, entry.folder ? "folder" : "file", {a.x + 15, (a.y + b.y) / 2}, 17,
               entry.folder ? c.accent : c.dim);
      const ImVec2 after = ImGui::GetCursorPos();
      ImGui::SetCursorScreenPos({a.x + 30, std::floor((a.y + b.y - ImGui::GetTextLineHeight()) / 2)});
      kit::elided(entry.name, width - 120, c.text);
      if (!entry.folder) {
        const std::string size = kit::bytes(entry.bytes);
        draw.AddText(
            {b.x - 10 - ImGui::CalcTextSize(size.c_str()).x, std::floor((a.y + b.y - ImGui::GetTextLineHeight()) / 2)},
            c.dim, size.c_str());
      }
      ImGui::SetCursorPos(after);
      ImGui::PopID();
    }
  }
  clipper.End();
  if (step != 0 && chosen_ >= 0) {
    const float top = float(chosen_) * kHeight, room = ImGui::GetWindowHeight() - 2 * 6;
    if (top < ImGui::GetScrollY()) ImGui::SetScrollY(top);
    if (top + kHeight > ImGui::GetScrollY() + room) ImGui::SetScrollY(top + kHeight - room);
  }
  ImGui::PopStyleVar();
  ImGui::EndChild();
  if (opened >= 0) done = chooses(entries_[size_t(opened)].name);

  const std::string typedBefore = typed_;
  if (!folders && kit::textField("##name", typed_, 0, "Name or path of a file", ImGui::IsWindowAppearing()) &&
      ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Enter), false) && !typed_.empty()) {
    done = chooses(typed_);
  }
  if (typed_ != typedBefore) marked_ = false;
  if (!problem_.empty()) kit::wrapped(problem_, colours().error);
  if (replaces)
    kit::elided(replacing_.filename().string() + " is there already: replace it?", ImGui::GetContentRegionAvail().x,
                colours().warning);
  if (more) more();
  const std::string_view verb = replaces ? std::string_view("Replace") : std::string_view(request_.verb);
  const float wide = std::max(96.0f, kit::buttonWidth(verb));
  ImGui::SetCursorPosX(ImGui::GetWindowContentRegionMax().x - 2 * wide - kGap);
  if (kit::button("Cancel", kit::Weight::plain, wide)) open_ = false;
  ImGui::SameLine();
  ImGui::BeginDisabled(!folders && typed_.empty() && !(marked_ && chosen_ >= 0));
  if (kit::mainButton(verb, wide, replaces ? kit::Weight::danger : kit::Weight::chief))
    done = chooses(marked_ && chosen_ >= 0 ? entries_[size_t(chosen_)].name : typed_);
  ImGui::EndDisabled();
  if (done) open_ = false;
  kit::endDialog(open_);
  return done;
}

}  // namespace argil::studio
