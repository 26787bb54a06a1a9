#include "ui3d/studio/widgets/picture_labels.h"

#include <imgui.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "render/view/scale.h"

namespace argil::studio {
namespace {

constexpr float kMargin = 20;  // From the corner of the free part.
constexpr float kTick = 4;

constexpr double kLeastContrast = 4.5;  // WCAG 2.1, text of usual size.

double luminance(double r, double g, double b) {
  const auto linear = [](double part) {
    part = std::clamp(part, 0.0, 1.0);
    return part <= 0.04045 ? part / 12.92 : std::pow((part + 0.055) / 1.055, 2.4);
  };
  return 0.2126 * linear(r) + 0.7152 * linear(g) + 0.0722 * linear(b);
}

}  // namespace

render::Colour readableOn(const render::Colour& ink, Theme theme) {
  const bool light = theme == Theme::light;
  const double ground = light ? 1 : luminance(20 / 255.0, 22 / 255.0, 26 / 255.0);
  const auto contrast = [&](const render::Colour& c) {
    const double mine = luminance(double(c.r), double(c.g), double(c.b));
    return (std::max(mine, ground) + 0.05) / (std::min(mine, ground) + 0.05);
  };
  render::Colour readable = ink;
  for (int step = 0; step < 32 && contrast(readable) < kLeastContrast; ++step)
    for (float* part : {&readable.r, &readable.g, &readable.b})
      *part = light ? 0.9f * *part : *part + 0.1f * (1 - *part);
  return readable;
}

void drawLabel(const Widgets::Label& label, Theme theme) {
  const auto byte = [](float part) { return ImU32(std::lround(255 * std::clamp(part, 0.0f, 1.0f))); };
  const ImVec2 size = ImGui::CalcTextSize(label.text.c_str());
  const ImVec2 at(std::round(label.x - size.x / 2), std::round(label.y - size.y / 2));
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  list.AddRectFilled(ImVec2(at.x - 6, at.y - 3), ImVec2(at.x + size.x + 6, at.y + size.y + 3),
                     theme == Theme::light ? IM_COL32(255, 255, 255, 225) : IM_COL32(20, 22, 26, 215), 4);
  const render::Colour ink = readableOn(label.colour, theme);
  list.AddText(at, IM_COL32(byte(ink.r), byte(ink.g), byte(ink.b), 255), label.text.c_str());
}

void drawScaleBar(const render::View& view, const std::array<float, 4>& free, float width, float height,
                  const StudioState& state) {
  const render::ScaleBar bar = render::scaleBar(view, int(width), int(height));
  ImDrawList& list = *ImGui::GetBackgroundDrawList();
  const bool light = state.look.lightBackground;
  const ImU32 ink = light ? IM_COL32(25, 28, 30, 255) : IM_COL32(238, 240, 242, 255);
  const ImU32 edge = light ? IM_COL32(255, 255, 255, 150) : IM_COL32(10, 10, 12, 150);
  const float left = std::round(free[0] + kMargin), right = std::round(left + float(bar.pixels)),
              y = std::round(free[3] - kMargin);
  if (right + kMargin > free[2]) return;  // No room.
  const auto lines = [&](ImU32 colour, float wide) {
    list.AddLine(ImVec2(left, y), ImVec2(right, y), colour, wide);
    for (const float x : {left, right}) list.AddLine(ImVec2(x, y - kTick), ImVec2(x, y + kTick), colour, wide);
  };
  lines(edge, 4);
  lines(ink, 1.5f);
  const auto text = [&](ImVec2 at, const std::string& words) {
    at = ImVec2(std::round(at.x), std::round(at.y));
    for (const ImVec2 by : {ImVec2(1, 0), ImVec2(-1, 0), ImVec2(0, 1), ImVec2(0, -1)})
      list.AddText(ImVec2(at.x + by.x, at.y + by.y), edge, words.c_str());
    list.AddText(at, ink, words.c_str());
  };
  const std::string length = render::lengthLabel(bar.mm);
  const ImVec2 size = ImGui::CalcTextSize(length.c_str());
  text(ImVec2((left + right - size.x) / 2, y - size.y - 5), length);
  if (!state.look.grid) return;
  const std::string grid = "grid " + render::lengthLabel(render::gridSpacing(view, int(height)).minor);
  if (right + 14 + ImGui::CalcTextSize(grid.c_str()).x < free[2]) text(ImVec2(right + 14, y - size.y / 2), grid);
}

}  // namespace argil::studio
