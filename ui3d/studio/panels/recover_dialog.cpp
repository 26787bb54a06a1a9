// What crashed sessions left: to be taken back or thrown away.

#include <algorithm>
#include <cmath>
#include <utility>

#include "ui3d/studio/files/save_words.h"
#include "ui3d/studio/kit/icons.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace fs = std::filesystem;
namespace {

constexpr float kWide = 96;

void begin(Context& context, Memory& memory, const engine::Recoverable& what, const engine::RecoverChoice& how = {}) {
  memory.recoverOpen = false;
  depart(context, memory, {.to = Departure::To::recovered, .what = what, .how = how});
}

// What can be done beside recovering it as it is.
void otherWays(Context& context, Memory& memory, const engine::Recoverable& what) {
  const bool repeats = what.strokes > 0 && what.leavesOut == 0;
  if (!what.fileMissing && !repeats) return;
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + 32);
  engine::RecoverChoice how;
  if (what.fileMissing) {
    if (kit::button("Locate…", kit::Weight::plain, kWide)) {
      memory.recoverOpen = false;
      memory.located = what;
      memory.filesFor = FilesFor::locate;
      memory.files.open({"Where the saved document lies now", "Recover", {".argil"}, {}});
    }
    ImGui::SameLine();
    if (kit::button("Repair without it", kit::Weight::plain, kit::buttonWidth("Repair without it"))) {
      how.repair = true;
      begin(context, memory, what, how);
    }
    if (repeats) ImGui::SameLine();
  }
  if (repeats &&
      kit::button("Without the last stroke", kit::Weight::plain, kit::buttonWidth("Without the last stroke"))) {
    how.withoutLast = true;
    begin(context, memory, what, how);
  }
  kit::gap(4);
}

// One of the list, with what can be done about it.
void entry(Context& context, Memory& memory, const engine::Recoverable& what, bool main) {
  ImGui::PushID(what.journal.c_str());
  const float width = ImGui::GetContentRegionAvail().x;
  const ImVec2 at = ImGui::GetCursorScreenPos();
  drawIcon(*ImGui::GetWindowDrawList(), "history", {at.x + 12, at.y + 12}, 20, colours().accent);
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + 32);
  ImGui::BeginGroup();
  ImGui::PushFont(fonts().strong);
  kit::elided(what.file.empty() ? "Untitled" : what.file.filename().string(), width - 32, colours().text);
  ImGui::PopFont();
  if (!what.file.empty()) kit::elided(what.file.parent_path().string(), width - 32, colours().dim);
  const bool any = what.some();  // Else the sentence says why there is nothing.
  if (any) kit::text(kit::sentence(spanWords(what.from, what.to, std::chrono::system_clock::now())));
  if (!what.sentence.empty()) kit::wrapped(kit::sentence(what.sentence), any ? colours().text : colours().warning);
  ImGui::EndGroup();
  kit::gap(6);
  otherWays(context, memory, what);
  const bool doubted = memory.recoverDoubted == what.journal;
  const float discard = doubted ? kit::buttonWidth("Discard for good") : kWide;
  ImGui::SetCursorPosX(ImGui::GetCursorPosX() + width - discard - kWide - kGap);
  if (kit::button(doubted ? "Discard for good" : "Discard", doubted ? kit::Weight::danger : kit::Weight::plain,
                  discard)) {
    if (doubted) {
      context.bench.discard(what);
    } else {
      memory.recoverDoubted = what.journal;
    }
  }
  ImGui::SameLine();
  ImGui::BeginDisabled(!any);
  if (main ? kit::mainButton("Recover", kWide) : kit::button("Recover", kit::Weight::chief, kWide)) {
    begin(context, memory, what);
  }
  ImGui::EndDisabled();
  ImGui::PopID();
}

}  // namespace

void drawRecover(Context& context, Memory& memory) {
  const auto list = context.bench.recoverable();
  if (list && !std::exchange(memory.recoverOffered, true) && !list->empty() && context.state.offersRecovery)
    memory.recoverOpen = true;
  if (!memory.recoverOpen) memory.recoverDoubted.clear();
  static const std::vector<engine::Recoverable> kNone;
  const std::vector<engine::Recoverable>& offered = list ? *list : kNone;
  if (!kit::beginDialog("Recover", "Recover unsaved work", 560, 0, &memory.recoverOpen)) return;
  if (offered.empty())
    kit::wrapped("There is nothing to recover.", colours().text);
  else
    kit::wrapped("Argil ended without saving. Its journal kept what was done:", colours().dim);
  kit::gap(4);
  // All at once where they fit: most people have one.
  const float most = std::floor(0.62f * context.height);
  if (offered.size() > 3) {
    ImGui::BeginChild("journals", {0, most});
    kit::sharpen(*ImGui::GetWindowDrawList());
  }
  const auto first = size_t(std::find_if(offered.begin(), offered.end(), [](const auto& each) { return each.some(); }) -
                            offered.begin());
  for (size_t i = 0; i < offered.size(); ++i) {
    if (i > 0) {
      const ImVec2 at = ImGui::GetCursorScreenPos();
      ImGui::GetWindowDrawList()->AddLine({at.x, at.y + 3}, {at.x + ImGui::GetContentRegionAvail().x, at.y + 3},
                                          colours().line, 1);
      kit::gap(12);
    }
    entry(context, memory, offered[i], i == first);
  }
  if (offered.size() > 3) ImGui::EndChild();
  kit::gap(8);
  ImGui::SetCursorPosX(ImGui::GetWindowContentRegionMax().x - kWide);
  if (offered.empty() ? kit::mainButton("Close", kWide) : kit::button("Later", kit::Weight::plain, kWide))
    memory.recoverOpen = false;
  kit::endDialog(memory.recoverOpen);
}

}  // namespace argil::studio
