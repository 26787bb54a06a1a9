// A number that is dragged and typed.

#include <imgui_internal.h>
#include <imgui_stdlib.h>

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <limits>

#include "ui3d/studio/kit/kit.h"
#include "ui3d/studio/kit/theme.h"

namespace argil::studio::kit {
namespace {

struct Typing {
  ImGuiID id = 0;  // Of the row that is typed into; 0: none.
  bool begun = false;
  std::string text;
};
Typing typing;  // One keyboard, one row.

double part(const Number& row, double value) {
  if (row.logarithmic) return std::log(std::max(value, row.low) / row.low) / std::log(row.high / row.low);
  return (value - row.low) / (row.high - row.low);
}
double valueAt(const Number& row, double t) {
  t = std::clamp(t, 0.0, 1.0);
  if (row.logarithmic) return row.low * std::pow(row.high / row.low, t);
  return row.low + t * (row.high - row.low);
}
// What a drag leaves is a round number.
double rounded(const Number& row, double value) {
  const double step = row.logarithmic ? std::pow(10, std::floor(std::log10(value)) - 2)
                                      : std::pow(10, std::floor(std::log10((row.high - row.low) / 200)));
  return std::clamp(std::round(value / step) * step, row.low, row.high);
}

Change type(const Number& row, double& value, float width) {
  ImGui::SetNextItemWidth(width);
  if (!typing.begun) ImGui::SetKeyboardFocusHere();
  ImGui::PushStyleVar(ImGuiStyleVar_FrameBorderSize, 1);
  const bool entered = ImGui::InputText("##typed", &typing.text,
                                        ImGuiInputTextFlags_EnterReturnsTrue | ImGuiInputTextFlags_AutoSelectAll);
  ImGui::PopStyleVar();
  const bool left = typing.begun && (!ImGui::IsItemActive() || ImGui::IsKeyPressed(ImGui::GetKeyIndex(ImGuiKey_Tab)));
  if (ImGui::IsItemActive()) typing.begun = true;
  if (!entered && !left) return {};
  typing.id = 0;
  if (ImGui::IsItemActive()) ImGui::ClearActiveID();  // Tab took the number: the field goes.
  const double typed = readNumber(typing.text);
  if (!std::isfinite(typed)) return {};
  const double next = row.open ? typed : std::clamp(typed, row.low, row.high);
  if (written(next) == written(value)) return {};  // Left as it stood there: keeps the digits that are not shown.
  value = next;
  return {true, true};
}

}  // namespace

bool numberIsTyped() {
  return typing.id != 0;
}

std::string written(double value) {
  constexpr int kMostDigits = 12;  // Behind the point: less is 0.
  if (!std::isfinite(value)) return "–";
  const double size = std::abs(value);
  const int digits = size >= 100                ? 0
                     : size >= 10               ? 1
                     : size >= 0.1 || size == 0 ? 2
                     : size >= 0.01             ? 3
                     : size >= 1e-4             ? 5
                                                : std::min(kMostDigits, 2 - int(std::floor(std::log10(size))));
  char text[340];
  std::snprintf(text, sizeof text, "%.*f", digits, value);
  std::string result = text;
  if (digits > 0 && result.find('.') != std::string::npos) {
    result.erase(result.find_last_not_of('0') + 1);
    if (result.back() == '.') result.pop_back();
  }
  return result == "-0" ? "0" : result;
}

double readNumber(const std::string& text) {
  std::string digits = text;
  std::replace(digits.begin(), digits.end(), ',', '.');
  const size_t begin = digits.find_first_not_of(" \t+");
  double value = 0;
  if (begin == std::string::npos) return std::numeric_limits<double>::quiet_NaN();
  const auto [end, error] = std::from_chars(digits.data() + begin, digits.data() + digits.size(), value);
  return error == std::errc() ? value : std::numeric_limits<double>::quiet_NaN();
}

std::string counted(uint64_t count) {
  std::string text = std::to_string(count);
  for (int at = int(text.size()) - 3; at > 0; at -= 3) text.insert(size_t(at), "\u202f");
  return text;
}

std::string bytes(uint64_t count) {
  static constexpr const char* kUnits[] = {"B", "kB", "MB", "GB", "TB"};
  double value = double(count);
  int unit = 0;
  for (; value >= 1000 && unit < 4; ++unit) value /= 1000;
  return written(value) + " " + kUnits[unit];
}

Change number(const Number& row, double& value, float width) {
  Change change;
  if (width <= 0) width = ImGui::GetContentRegionAvail().x;
  ImGui::PushID(row.id.data(), row.id.data() + row.id.size());
  const ImGuiID id = ImGui::GetID("bar");
  if (typing.id == id) {
    change = type(row, value, width);
    ImGui::PopID();
    return change;
  }

  ImGui::InvisibleButton("bar", {width, kRow});
  const bool hovered = ImGui::IsItemHovered(), held = ImGui::IsItemActive();
  const ImVec2 a = ImGui::GetItemRectMin(), b = ImGui::GetItemRectMax();
  const ImGuiIO& io = ImGui::GetIO();
  ImGuiStorage& storage = *ImGui::GetStateStorage();
  // Where on the bar the drag stands: a value would lose what rounding takes.
  const ImGuiID grip = ImGui::GetID("grip");
  if (hovered && (ImGui::IsMouseDoubleClicked(0) || (ImGui::IsMouseClicked(0) && io.KeyCtrl))) {
    typing = {id, false, written(value)};
    ImGui::ClearActiveID();
  } else if (ImGui::IsItemActivated()) {
    storage.SetFloat(grip, float(part(row, value)));
  } else if (held && io.MouseDelta.x != 0 && ImGui::IsMouseDragging(0, 2)) {
    const float t =
        std::clamp(storage.GetFloat(grip) + io.MouseDelta.x / width * (io.KeyShift ? 0.1f : 1.0f), 0.0f, 1.0f);
    storage.SetFloat(grip, t);
    const double next = rounded(row, valueAt(row, t));
    change.changed = next != value;
    value = next;
  }
  if (ImGui::IsItemDeactivated()) change.ended = true;
  if (hovered && ImGui::IsMouseClicked(1) && value != row.standard) {
    value = row.standard;
    change = {true, true};
  }

  ImDrawList& list = *ImGui::GetWindowDrawList();
  const Colours& c = colours();
  const auto faded = [](ImU32 colour) { return ImGui::GetColorU32(ImGui::ColorConvertU32ToFloat4(colour)); };
  list.AddRectFilled(a, b, faded(hovered || held ? c.fieldHover : c.field), kRound);
  const float filled = float(std::clamp(part(row, value), 0.0, 1.0)) * width;
  if (filled > 0.5f) {
    list.PushClipRect(a, {a.x + filled, b.y}, true);
    list.AddRectFilled(a, b, faded(c.level), kRound);
    list.PopClipRect();
    list.PushClipRect({a.x, b.y - 2.5f}, {a.x + filled, b.y}, true);
    list.AddRectFilled(a, b, faded(c.accent), kRound);
    list.PopClipRect();
  }
  list.AddRect(a, b, faded(held ? c.accent : c.line), kRound, 0, 1);
  const float y = std::floor((a.y + b.y - ImGui::GetTextLineHeight()) / 2);
  const std::string unit = row.unit.empty() || row.unit == "°" ? std::string(row.unit) : " " + std::string(row.unit);
  const std::string shown = value == 0 && !row.zero.empty() ? std::string(row.zero) : written(value) + unit;
  const float right = ImGui::CalcTextSize(shown.c_str()).x;
  const ImVec2 needed = ImGui::CalcTextSize(row.name.data(), row.name.data() + row.name.size());
  const float edge = b.x - right - 14;
  ImGui::RenderTextEllipsis(&list, {a.x + 9, y}, {edge, b.y}, edge, edge, row.name.data(),
                            row.name.data() + row.name.size(), &needed);
  list.AddText({b.x - right - 9, y}, faded(c.text), shown.c_str());
  if (hovered && !held) {
    const std::string range = written(row.low) + " to " + written(row.high) +
                              (row.unit.empty() ? "" : " " + std::string(row.unit)) +
                              ". Drag; double-click to type; right-click for " + written(row.standard) + ".";
    tooltip(row.help.empty() ? range : std::string(row.help) + "\n" + range);
  }
  ImGui::PopID();
  return change;
}

}  // namespace argil::studio::kit
