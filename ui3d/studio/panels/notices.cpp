// What was said and what is under way, at the foot of the picture; and the list of all messages.

#include <algorithm>

#include "ui3d/studio/kit/icons.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace {

using Level = engine::Message::Level;
constexpr double kJobShownS = 0.3;
constexpr double kSeenS[] = {4, 8, 15};  // Done, warning, error.
constexpr size_t kMostToasts = 4;

ImU32 colourOf(Level level) {
  const Colours& c = colours();
  return level == Level::done ? c.good : level == Level::warning ? c.warning : c.error;
}
std::string_view iconOf(Level level) {
  return level == Level::done ? "check" : level == Level::warning ? "warning" : "error";
}

}  // namespace

void drawNotices(Context& context, Memory& memory) {
  const kit::Rect& free = memory.layout.clear;
  std::vector<engine::JobView> jobs = context.bench.jobs();
  memory.moves |= !jobs.empty();
  std::erase_if(jobs, [](const engine::JobView& job) { return job.seconds < kJobShownS; });
  const std::string& trouble = context.now.file.journalTrouble;
  std::vector<Said*> toasts;
  for (auto said = memory.said.rbegin(); said != memory.said.rend() && toasts.size() < kMostToasts; ++said) {
    if (!trouble.empty() && said->message.text == trouble) continue;  // It stands there anyway.
    if (!said->dismissed && context.timeS - said->timeS < kSeenS[size_t(said->message.level)]) toasts.push_back(&*said);
  }
  memory.moves |= !toasts.empty();
  // Work goes on in memory alone: said as long as it is so.
  memory.noticesHeight = 0;
  if ((jobs.empty() && toasts.empty() && trouble.empty()) || free.width() < 120) return;

  const float width = std::min(420.0f, free.width() - 24);
  kit::beginCard("Notices", {std::floor((free.left + free.right) / 2), free.bottom - 14}, {0.5f, 1}, width,
                 free.height() - 28);
  if (!trouble.empty()) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    drawIcon(*ImGui::GetWindowDrawList(), iconOf(Level::warning), {at.x + 9, at.y + 9}, 18, colourOf(Level::warning));
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + 28);
    ImGui::PushTextWrapPos(width - 16);
    kit::text(kit::sentence(trouble));
    ImGui::PopTextWrapPos();
  }
  for (auto toast = toasts.rbegin(); toast != toasts.rend(); ++toast) {
    Said& said = **toast;
    ImGui::PushID(&said);
    const ImVec2 at = ImGui::GetCursorScreenPos();
    drawIcon(*ImGui::GetWindowDrawList(), iconOf(said.message.level), {at.x + 9, at.y + 9}, 18,
             colourOf(said.message.level));
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + 28);
    ImGui::PushTextWrapPos(width - 44);
    kit::text(said.message.text);
    ImGui::PopTextWrapPos();
    ImGui::SameLine(width - 36);
    if (kit::iconButton("dismiss", "close", 22, kit::Lit::off, "Dismiss; the Messages panel keeps it"))
      said.dismissed = true;
    ImGui::PopID();
  }
  for (const engine::JobView& job : jobs) {
    ImGui::PushID(int(job.id));
    kit::elided(job.name, width - 150, colours().text);
    const std::string percent = std::to_string(int(100 * std::clamp(job.fraction, 0.0, 1.0))) + " %";
    ImGui::SameLine(width - 126);
    kit::dimText(percent);
    ImGui::SameLine(width - 12 - kit::buttonWidth("Cancel"));
    ImGui::SetCursorPosY(ImGui::GetCursorPosY() - 4);
    if (kit::button("Cancel")) context.bench.cancelJob(job.id);
    kit::bar(job.fraction, width - 24);
    ImGui::PopID();
  }
  memory.noticesHeight = ImGui::GetWindowHeight() + 14;
  kit::endCard();
}

void messagesPanel(Context&, Memory& memory) {
  if (memory.said.empty()) kit::wrapped("Nothing was said yet.", colours().dim);
  for (auto said = memory.said.rbegin(); said != memory.said.rend(); ++said) {
    const ImVec2 at = ImGui::GetCursorScreenPos();
    drawIcon(*ImGui::GetWindowDrawList(), iconOf(said->message.level), {at.x + 8, at.y + 9}, 16,
             colourOf(said->message.level));
    ImGui::SetCursorPosX(ImGui::GetCursorPosX() + 24);
    kit::wrapped(said->message.text, colours().text);
  }
}

}  // namespace argil::studio
