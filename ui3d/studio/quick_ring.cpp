#include "ui3d/studio/quick_ring.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "ui3d/studio/kit/theme.h"

namespace argil::studio {
namespace {

constexpr float kPi = std::numbers::pi_v<float>, kEach = 2 * kPi / QuickRing::kItems;
constexpr float kEdge = 4;  // To the window's edge.

// Of an item's middle, from the right, clockwise as the window counts; the first is at the top.
float angleOf(QuickRing::Item item) {
  return -kPi / 2 + kEach * float(int(item) - 1);
}

}  // namespace

QuickRing QuickRing::around(float x, float y, float width, float height) {
  QuickRing ring;
  ring.shown = std::min(1.0f, std::min(width, height) / (2 * (kOuter + kEdge)));
  const float room = ring.shown * (kOuter + kEdge);
  ring.x = std::clamp(x, room, std::max(room, width - room));
  ring.y = std::clamp(y, room, std::max(room, height - room));
  return ring;
}

QuickRing::Item QuickRing::at(float px, float py) const {
  const float dx = px - x, dy = py - y, away = std::hypot(dx, dy);
  if (!(away > shown * kInner && away <= shown * kOuter)) return Item::none;
  const float turns = (std::atan2(dy, dx) + kPi / 2) / kEach;
  return Item(1 + (int(std::lround(turns)) + kItems) % kItems);
}

std::array<float, 2> QuickRing::place(Item item) const {
  const float away = shown * (kInner + kOuter) / 2;
  return {x + away * std::cos(angleOf(item)), y + away * std::sin(angleOf(item))};
}

const char* QuickRing::name(Item item) {
  switch (item) {
    case Item::none:
      return "";
    case Item::zoom:
      return "Zoom";
    case Item::redo:
      return "Redo";
    case Item::all:
      return "Show all";
    case Item::move:
      return "Move";
    case Item::size:
      return "Size";
    case Item::undo:
      return "Undo";
  }
  return "";
}

void QuickRing::draw(Item hot) const {
  ImDrawList& list = *ImGui::GetForegroundDrawList();
  const Colours& c = colours();
  for (int i = 1; i <= kItems; ++i) {
    const Item item = Item(i);
    const float middle = angleOf(item), from = middle - kEach / 2, to = middle + kEach / 2;
    // A ring's part is not convex: its fill is a thick arc.
    list.PathArcTo({x, y}, shown * (kInner + kOuter) / 2, from, to, 24);
    list.PathStroke(item == hot ? c.accent : c.panel, 0, shown * (kOuter - kInner));
    const char* words = name(item);
    const ImVec2 size = ImGui::CalcTextSize(words);
    const auto [px, py] = place(item);
    list.AddText({std::round(px - size.x / 2), std::round(py - size.y / 2)}, item == hot ? c.onAccent : c.text, words);
  }
  for (int i = 1; i <= kItems; ++i) {
    const float angle = angleOf(Item(i)) + kEach / 2, dx = shown * std::cos(angle), dy = shown * std::sin(angle);
    list.AddLine({x + kInner * dx, y + kInner * dy}, {x + kOuter * dx, y + kOuter * dy}, c.line, 1.5f);
  }
  list.AddCircle({x, y}, shown * kOuter, c.line, 64, 1);
}

}  // namespace argil::studio
