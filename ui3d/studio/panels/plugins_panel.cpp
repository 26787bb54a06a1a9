// The plugins that are there: what each brings, what it may, and whether it is used.

#include <fmt/format.h>

#include <chrono>
#include <cmath>
#include <utility>

#include "clay/base/error.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace {

using engine::FoundPlugin;
using engine::PluginState;

constexpr float kWidth = 560, kHeight = 560, kButton = 100;

// They are read beside the studio: a library may be large.
void look(PluginsPage& page) {
  if (page.found || page.reading.valid()) return;
  page.reading = std::async(std::launch::async, [] {
    engine::Plugins plugins;
    plugins.compareLibraries();
    return plugins;
  });
}

std::string namesOf(const engine::Plugin& plugin) {
  std::string names;
  for (const engine::Brought& each : engine::broughtBy(plugin)) names += (names.empty() ? "" : ", ") + each.name;
  return names;
}

// What was enabled is a tool from now on; what was disabled goes with the program, as steps and hands may name it.
void change(Context& context, PluginsPage& page, const FoundPlugin& plugin, bool enable) {
  const std::string id = plugin.plugin.id, name = plugin.plugin.name;
  page.problem.clear();
  try {
    if (enable) {
      page.found->enable(id);
      page.found->load();
    } else {
      page.found->disable(id);
    }
  } catch (const Error& error) {
    page.problem = error.what();
    return;
  }
  const FoundPlugin* now = page.found->find(id);
  if (enable && !now)
    page.problem = fmt::format("{} is used when Argil is started again: another state of it is in use.", name);
  else
    context.bench.tell(engine::Message::Level::done,
                       enable ? fmt::format("{} is enabled. It brings {}.", name, namesOf(now->plugin))
                              : fmt::format("{} is disabled; what it brings goes when Argil is started again.", name));
}

void drawOne(PluginsPage& page, const FoundPlugin& found) {
  const Colours& c = colours();
  const bool readable = found.state != PluginState::broken;
  const std::string name =
      readable ? fmt::format("{} {}", found.plugin.name, found.plugin.version) : found.folder.filename().string();
  const float width = ImGui::GetContentRegionAvail().x, top = ImGui::GetCursorPosY();
  ImGui::PushFont(fonts().strong);
  ImGui::SetCursorPosY(top + std::floor((kRow - ImGui::GetTextLineHeight()) / 2));
  kit::elided(name, width - kButton - kGap, c.text);
  ImGui::PopFont();
  const bool on = found.state == PluginState::enabled;
  if (readable && found.state != PluginState::hidden) {
    ImGui::SameLine(width - kButton);
    ImGui::SetCursorPosY(top);
    const bool pressed = kit::button(on                                    ? "Disable"
                                     : found.state == PluginState::changed ? "Enable anew"
                                                                           : "Enable",
                                     on ? kit::Weight::plain : kit::Weight::chief, kButton);
    if (pressed) page.pressed = {found.plugin.id, !on};
  }
  if (!readable) return kit::wrapped(found.problem, c.warning);
  kit::wrapped(found.plugin.help, c.text);
  kit::fact("Brings", namesOf(found.plugin));
  kit::fact("State", engine::nameOf(found.state), on ? c.text : c.dim);
  kit::fact("Licence", found.plugin.licence);
  kit::wrapped(engine::mayOf(found.plugin), c.dim);
  kit::dimText(found.folder.string());
}

}  // namespace

void drawPlugins(Context& context, Memory& memory) {
  PluginsPage& page = memory.plugins;
  bool& open = context.state.shown.plugins;
  if (!kit::beginDialog("Plugins", "Plugins", kWidth, kHeight, &open)) {
    page = {};
    return;
  }
  look(page);
  if (page.reading.valid() && page.reading.wait_for(std::chrono::seconds(0)) == std::future_status::ready)
    page.found = page.reading.get();
  kit::wrapped("A plugin is used once you have enabled it, as it is at that moment. When it changes, it asks again.",
               colours().dim);
  if (!page.problem.empty()) kit::wrapped(page.problem, colours().error);
  ImGui::BeginChild("list", {0, ImGui::GetContentRegionAvail().y - kRow - kGap});
  kit::sharpen(*ImGui::GetWindowDrawList());
  if (!page.found) {
    kit::dimText("Reading…");
    memory.moves = true;
  } else {
    if (!page.found->problem().empty()) kit::wrapped(page.found->problem(), colours().error);
    if (page.found->found().empty()) {
      kit::wrapped("There are none yet. They are looked for in", colours().text);
      for (const auto& folder : engine::pluginFolders()) kit::dimText(folder.string());
    }
    int number = 0;
    for (const FoundPlugin& each : page.found->found()) {
      if (number > 0) kit::gap(10);
      ImGui::PushID(number++);
      drawOne(page, each);
      ImGui::PopID();
    }
  }
  ImGui::EndChild();
  if (kit::button("Read again")) page = {};
  ImGui::SameLine();
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() + std::floor((kRow - ImGui::GetTextLineHeight()) / 2));
  kit::dimText("argil plugins new brush FOLDER writes one to begin with.");
  ImGui::SameLine(ImGui::GetWindowContentRegionMax().x - 96);
  ImGui::SetCursorPosY(ImGui::GetCursorPosY() - std::floor((kRow - ImGui::GetTextLineHeight()) / 2));
  if (kit::mainButton("Done", 96)) open = false;
  // Behind the list, which it changes.
  if (const auto [id, enable] = std::exchange(page.pressed, {}); !id.empty() && page.found)
    if (const FoundPlugin* plugin = page.found->find(id)) change(context, page, *plugin, enable);
  kit::endDialog(open);
}

}  // namespace argil::studio
