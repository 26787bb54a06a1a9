#include <algorithm>
#include <array>
#include <cmath>

#include "engine/plugins/felt_guides.h"
#include "haptics/devices/sheets.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/panels/settings_tables.h"

namespace argil::studio {
namespace {

// A field to plot in, with its edges.
kit::Rect plotField(float height) {
  const float width = ImGui::GetContentRegionAvail().x;
  ImGui::Dummy({width, height});
  const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
  ImGui::GetWindowDrawList()->AddRectFilled(a, b, colours().bar, kRound);
  ImGui::GetWindowDrawList()->AddRect(a, b, colours().line, kRound, 0, 1);
  return {a.x, a.y, b.x, b.y};
}

void inField(const kit::Rect& field, float x, float y, const std::string& words, bool right = false) {
  ImGui::PushFont(fonts().small);
  const float width = ImGui::CalcTextSize(words.c_str()).x;
  ImGui::GetWindowDrawList()->AddText({right ? field.right - width - x : field.left + x, field.top + y}, colours().dim,
                                      words.c_str());
  ImGui::PopFont();
}

void plotForce(const std::vector<float>& forceN, double peakN, bool stopped) {
  const kit::Rect field = plotField(86);
  float most = 0;
  for (const float f : forceN) most = std::max(most, f);
  const double top = std::max({double(most) * 1.1, peakN, 0.5});
  const auto y = [&](double newton) { return float(field.bottom - 3 - newton / top * (field.height() - 8)); };
  ImDrawList& list = *ImGui::GetWindowDrawList();
  if (peakN > 0) list.AddLine({field.left + 1, y(peakN)}, {field.right - 1, y(peakN)}, colours().warning, 1);
  if (forceN.size() > 1) {
    // A column of pixels shows the most of what falls into it: a kick of one tick is not to be missed.
    const int columns = std::min(int(field.width()) - 4, int(forceN.size()));
    std::vector<ImVec2> points;
    for (int i = 0; i < columns; ++i) {
      const size_t from = size_t(i) * forceN.size() / size_t(columns),
                   to = std::max(from + 1, size_t(i + 1) * forceN.size() / size_t(columns));
      const float value = *std::max_element(forceN.begin() + long(from), forceN.begin() + long(to));
      points.push_back({field.left + 2 + (field.width() - 4) * float(i) / float(std::max(1, columns - 1)), y(value)});
    }
    list.AddPolyline(points.data(), int(points.size()), stopped ? colours().dim : colours().accent, 0, 1.5f);
  }
  if (stopped) {
    const std::string words = "Forces are stopped";
    ImGui::PushFont(fonts().strong);
    const ImVec2 size = ImGui::CalcTextSize(words.c_str());
    list.AddText(
        {std::floor((field.left + field.right - size.x) / 2), std::floor((field.top + field.bottom - size.y) / 2)},
        colours().warning, words.c_str());
    ImGui::PopFont();
  }
  inField(field, 7, 4, "force, last 2 s");
  inField(field, 7, 4, kit::written(most) + " N", true);
}

// Bars over times on a scale of powers of ten, from 1 µs to 10 ms.
void plotTimes(const char* name, const haptics::Histogram& times) {
  const kit::Rect field = plotField(58);
  inField(field, 7, 4, name);
  inField(field, 7, 4, times.count() ? kit::counted(times.count()) + " ticks" : "nothing yet", true);
  if (times.count() == 0) return;
  constexpr int kBars = 48, kProbes = 400;
  constexpr double kDecades = 4;
  std::array<int, kBars> bars{};
  for (int i = 0; i < kProbes; ++i) {
    const double us = std::max(1.0, times.quantileUs((i + 0.5) / kProbes));
    ++bars[size_t(std::clamp(int(std::log10(us) / kDecades * kBars), 0, kBars - 1))];
  }
  const int most = *std::max_element(bars.begin(), bars.end());
  const float wide = (field.width() - 8) / kBars, room = field.height() - 26;
  ImDrawList& list = *ImGui::GetWindowDrawList();
  for (int i = 0; i < kBars; ++i) {
    if (bars[size_t(i)] == 0) continue;
    const float x = field.left + 4 + float(i) * wide,
                high = std::max(1.5f, room * float(bars[size_t(i)]) / float(most));
    list.AddRectFilled({x, field.bottom - 3 - high}, {x + wide - 1, field.bottom - 3}, colours().accent);
  }
  for (int decade = 1; decade < int(kDecades); ++decade) {
    const float x = field.left + 4 + float(decade) / float(kDecades) * (field.width() - 8);
    list.AddLine({x, field.bottom - 7}, {x, field.bottom - 1}, colours().dim, 1);
  }
  kit::fact("p50 · p99", kit::written(times.quantileUs(0.5)) + " · " + kit::written(times.quantileUs(0.99)) + " µs");
  kit::fact("p99.9 · most", kit::written(times.quantileUs(0.999)) + " · " + kit::written(times.maxUs()) + " µs");
}

void chooseDevice(Context& context, Memory& memory) {
  constexpr double kLookEveryS = 2;
  if (context.timeS - memory.foundAtS > kLookEveryS) {
    memory.found = haptics::findDevices();
    memory.foundAtS = context.timeS;
  }
  struct Choice {
    std::string name, shown;
  };
  std::vector<Choice> choices{{"pointer", "Mouse or pen"}};
  for (const haptics::FoundDevice& found : memory.found) choices.push_back({found.name, found.what});
  for (const haptics::DeviceSheet& sheet : haptics::deviceSheets())
    choices.push_back({"simulated:" + sheet.name, "Simulated " + sheet.like});
  std::vector<std::string_view> names;
  int chosen = -1;
  for (const Choice& choice : choices) {
    if (choice.name == memory.touch.device) chosen = int(names.size());
    names.push_back(choice.shown);
  }
  if (kit::choice("", names, chosen, "What the hand holds.")) context.bench.useDevice(choices[size_t(chosen)].name);
  for (const haptics::FoundDevice& found : memory.found) {
    if (!found.problem.empty()) kit::wrapped(found.what + ": " + found.problem, colours().warning);
  }
}

void limits(const haptics::DeviceSheet& sheet) {
  kit::heading("Limits of " + (sheet.like.empty() ? sheet.name : sheet.like));
  const Vec3d& w = sheet.workspaceMm;
  kit::fact("Reach", kit::written(w.x()) + " × " + kit::written(w.y()) + " × " + kit::written(w.z()) + " mm");
  kit::fact("Force, at most", kit::written(sheet.peakForceN) + " N");
  kit::fact("Force, for long", kit::written(sheet.continuousForceN) + " N");
  kit::fact("Stiffness, at most", kit::written(sheet.topStiffnessNmm) + " N/mm");
  kit::fact("Step of its sensors", kit::written(sheet.resolutionMm) + " mm");
  kit::fact("Exchanges", kit::written(sheet.rateHz) + " Hz");
  kit::fact("Axes in · out · buttons",
            std::to_string(sheet.dofIn) + " · " + std::to_string(sheet.dofOut) + " · " + std::to_string(sheet.buttons));
}

void reach(Context& context) {
  kit::heading("Reach of the hand");
  bool changed = drawRows(workspaceRows(), context.state.workspace).changed;
  const auto walls = wallRows();
  changed |= drawRows(context.state.workspace.walls.on ? walls : walls.first(1), context.state.workspace.walls).changed;
  if (changed) context.bench.setWorkspace(context.state.workspace);
  kit::toggle("Show the reach", context.state.showWorkspaceBox, "The box that the hand can reach, in the picture.");
}

void guidesOfPlugins(Context& context) {
  const auto guides = engine::feltGuides().all();
  if (guides.empty()) return;
  kit::heading("Guides of plugins");
  const std::vector<std::string> felt = context.bench.guidesFelt();
  for (const engine::FeltGuide* guide : guides) {
    bool on = std::find(felt.begin(), felt.end(), guide->id) != felt.end();
    if (kit::toggle(guide->name, on, guide->help)) context.bench.feelGuide(guide->id, on);
  }
}

// Times of the servo's ticks, its counters, what bounds its cost, the device's data sheet.
void advanced(Context& context, const engine::TouchState& touch) {
  const haptics::ServoStatistics& s = touch.statistics;
  plotTimes("compute", s.compute);
  plotTimes("lateness", s.lateness);
  const bool pointer = context.bench.usesPointer();
  if (!pointer) {
    kit::fact("Delay of the loop", kit::written(1e3 * touch.delayS) + " ms");
    kit::fact("Stiffness at that delay", kit::written(touch.stiffnessNmm) + " N/mm");
  }
  kit::fact("Ticks · late · missed",
            kit::counted(s.ticks) + " · " + kit::counted(s.overrun) + " · " + kit::counted(s.missed));
  kit::fact("Dropped samples · watchdog",
            kit::counted(touch.droppedSamples) + " · " + kit::counted(touch.watchdogCuts));
  if (!touch.grant.empty()) kit::wrapped(kit::sentence(touch.grant), colours().dim);
  if (pointer) return;
  kit::heading("Accuracy of touch");
  engine::Quality quality;
  quality.touch = context.state.touchQuality;
  if (drawRows(touchQualityRows(), quality).changed)
    context.bench.setTouchQuality(context.state.touchQuality = quality.touch);
  limits(touch.sheet);
}

}  // namespace

void touchPanel(Context& context, Memory& memory) {
  const engine::TouchState& touch = memory.touch;
  const bool pointer = context.bench.usesPointer(), stopped = forcesStopped(memory);
  chooseDevice(context, memory);
  if (!pointer || stopped) {
    const float width = ImGui::GetContentRegionAvail().x;
    ImGui::PushFont(fonts().strong);
    if (stopped ? kit::button("Resume forces", kit::Weight::chief, width, "play")
                : kit::button("STOP FORCES", kit::Weight::danger, width, "stop")) {
      runAction(context, stopped ? "touch.resume" : "touch.stop");
    }
    ImGui::PopFont();
  }
  const bool well =
      !stopped && (touch.state == haptics::ServoState::running || touch.state == haptics::ServoState::waiting ||
                   touch.state == haptics::ServoState::warm);
  if (!touch.sentence.empty())
    kit::wrapped(kit::sentence(touch.sentence), well ? colours().text : pointer ? colours().dim : colours().warning);
  if (context.bench.usesSimulated())
    kit::wrapped("The mouse moves it: it follows the pointer over the clay, and works while the left button is held.",
                 colours().dim);
  if (!touch.deviceStatus.empty()) kit::wrapped(kit::sentence(touch.deviceStatus), colours().dim);

  if (!pointer) {
    plotForce(touch.forceN, touch.sheet.peakForceN, stopped);
    kit::fact("Peak force", kit::written(touch.statistics.peakForceN) + " N");
    reach(context);
  }
  guidesOfPlugins(context);
  if (!kit::fold("Advanced", memory.touchOpen, "Times and limits of the touch, for developers.")) return;
  advanced(context, touch);
}

}  // namespace argil::studio
