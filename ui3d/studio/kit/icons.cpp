#include "ui3d/studio/kit/icons.h"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <cstdlib>
#include <numbers>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace argil::studio {
namespace {

// Drawings in a square of 24, as text: M x y begins a line, L x y goes on, A x y r from to an arc in degrees (clockwise
// from the right), Z closes it, F closes and fills it (convex); O x y r a circle, D x y r a disc. A line ends where
// another begins.
struct Icon {
  std::string_view name;
  const char* path;
};
constexpr std::array kIcons{
    Icon{"add", "M3 19 L5 16 A12 16 6.5 180 360 L21 19 Z M12 13 L12 20 M8.5 16.5 L15.5 16.5"},
    Icon{"angle", "M20 19 L4 19 L16 5 M13.5 19 A4 19 9.5 0 -48"},
    Icon{"block", "M12 3 L20 7.5 L20 16.5 L12 21 L4 16.5 L4 7.5 Z M4 7.5 L12 12 L20 7.5 M12 12 L12 21"},
    Icon{"box", "M12 3 L20 7.5 L20 16.5 L12 21 L4 16.5 L4 7.5 Z M8.5 9.5 L15.5 14.5 M15.5 9.5 L8.5 14.5"},
    Icon{"carve", "M3 15 L6.5 15 A12 14.5 5.5 180 0 L21 15 L21 21 L3 21 Z O12 6.5 4"},
    Icon{"check", "M4.5 12.5 L10 18 L19.5 6.5"},
    Icon{
        "clay",
        "M3 19.5 L21 19.5 M4.5 19.5 A12 19.5 7.5 180 360 M8 19.5 A12 19.5 4 180 360 M12 3 L12 8.5 M9.5 5.5 L12 3 L14.5 "
        "5.5"},
    Icon{"close", "M6 6 L18 18 M18 6 L6 18"},
    Icon{"curve", "M3 17 L5.5 12 L8.5 9.5 L11.5 11.5 L13 14 L16 15.5 L19 12.5 L21 7 D3 17 2 D11.7 11.7 2 D21 7 2"},
    Icon{"down", "M5 9 L12 16 L19 9"},
    Icon{"error", "O12 12 9 M8.5 8.5 L15.5 15.5 M15.5 8.5 L8.5 15.5"},
    Icon{"export", "M12 15 L12 3 M7.5 7.5 L12 3 L16.5 7.5 M4 13 L4 20 L20 20 L20 13"},
    Icon{
        "eye",
        "M2.5 12 L6 8 L9.5 6.2 L12 5.8 L14.5 6.2 L18 8 L21.5 12 L18 16 L14.5 17.8 L12 18.2 L9.5 17.8 L6 16 Z D12 12 3"},
    Icon{"eyeOff",
         "M2.5 12 L6 8 L9.5 6.2 L12 5.8 L14.5 6.2 L18 8 L21.5 12 L18 16 L14.5 17.8 L12 18.2 L9.5 17.8 L6 16 Z M4 20 "
         "L20 4"},
    Icon{"facts", "O12 12 9 M12 11 L12 17 D12 7.5 1.3"},
    Icon{"file", "M6 3 L14 3 L19 8 L19 21 L6 21 Z M14 3 L14 8 L19 8"},
    Icon{"folder", "M3 19 L3 5 L9 5 L11.5 8 L21 8 L21 19 Z"},
    Icon{"focus", "M4 8 L4 4 L8 4 M16 4 L20 4 L20 8 M20 16 L20 20 L16 20 M8 20 L4 20 L4 16 O12 12 3"},
    Icon{"history", "M5 7.5 A12 12 8.5 212 520 M4 3.5 L4.8 8 L9.3 7.6 M12 7.5 L12 12.5 L15.5 14.5"},
    Icon{"home", "M3 12 L12 4 L21 12 M5.5 10 L5.5 20 L10 20 L10 14.5 L14 14.5 L14 20 L18.5 20 L18.5 10"},
    Icon{"import", "M12 3 L12 15 M7.5 10.5 L12 15 L16.5 10.5 M4 13 L4 20 L20 20 L20 13"},
    Icon{"invert", "O12 12 8.5 M12 3.5 A12 12 8.5 -90 90 F"},
    Icon{"keys",
         "M2.5 6 L21.5 6 L21.5 18 L2.5 18 Z M6 9.7 L7 9.7 M10 9.7 L11 9.7 M14 9.7 L15 9.7 M17.6 9.7 L18 9.7 M7.5 14.5 "
         "L16.5 14.5"},
    Icon{"line", "M4 20 L20 4 D4 20 2.2 D20 4 2.2"},
    Icon{"lit",
         "O12 12 4 M12 2.5 L12 5 M12 19 L12 21.5 M2.5 12 L5 12 M19 12 L21.5 12 M5.3 5.3 L7 7 M17 17 L18.7 18.7 M18.7 "
         "5.3 L17 7 M7 17 L5.3 18.7"},
    Icon{"lock", "M5 11 L19 11 L19 20.5 L5 20.5 Z M8 11 L8 8 A12 8 4 180 360 L16 11 M12 14.5 L12 17"},
    Icon{"unlock", "M5 11 L19 11 L19 20.5 L5 20.5 Z M8 11 L8 7 A12 7 4 180 340 M12 14.5 L12 17"},
    Icon{"matcap", "O12 12 8.5 M6.8 12 A12 12 5.2 180 270"},
    Icon{"material", "O12 12 8.5 D9 8.5 2.2 M16.8 14 A12 12 5.4 22 75"},
    Icon{"messages", "M3 5 L21 5 L21 16.5 L12 16.5 L7.5 20.5 L7.5 16.5 L3 16.5 Z M7 9 L17 9 M7 12.5 L14 12.5"},
    Icon{"minus", "M5 12 L19 12"},
    Icon{"move",
         "M12 2.5 L12 21.5 M2.5 12 L21.5 12 M9.3 5.2 L12 2.5 L14.7 5.2 M9.3 18.8 L12 21.5 L14.7 18.8 M5.2 9.3 L2.5 12 "
         "L5.2 14.7 M18.8 9.3 L21.5 12 L18.8 14.7"},
    Icon{"none", ""},
    Icon{"ortho", "M4 8 L15 8 L15 20 L4 20 Z M4 8 L9 4 L20 4 L15 8 M20 4 L20 16 L15 20"},
    Icon{"plane", "M2.5 15 L9 7.5 L21.5 9 L15 17 Z M12 12 L12 3 M10 5 L12 3 L14 5"},
    Icon{"play", "M7 4.5 L19.5 12 L7 19.5 F"},
    Icon{"plus", "M12 5 L12 19 M5 12 L19 12"},
    Icon{"point", "D12 12 3 O12 12 7.5 M12 1.8 L12 4.5 M12 19.5 L12 22.2 M1.8 12 L4.5 12 M19.5 12 L22.2 12"},
    Icon{"plugins", "M8 3 L8 8 M16 3 L16 8 M5 8 L19 8 L19 12 A12 12 7 0 180 Z M12 19 L12 22"},
    Icon{"preferences", "M4 7 L12 7 M17 7 L20 7 O14.5 7 2.5 M4 17 L7 17 M12 17 L20 17 O9.5 17 2.5"},
    Icon{"print", "M4 4 L20 4 M12 4 L12 8 M9.5 8 L14.5 8 L12 11.5 Z M6 20 L6 15 L18 15 L18 20 M3 20 L21 20"},
    Icon{"quality", "M4.2 17.5 A12 13.5 8.7 152 388 M12 13.5 L16.5 8.5 D12 13.5 1.8"},
    Icon{"redo", "M19.5 9.5 L9 9.5 A9 14.5 5 -90 -270 L15 19.5 M15.5 5.5 L19.5 9.5 L15.5 13.5"},
    Icon{"rotate", "M19.8 8 A12 12 8.8 -27 -310 M20.3 3.2 L19.9 8.2 L15 7.7"},
    Icon{"ruler", "M3 16.5 L16.5 3 L21 7.5 L7.5 21 Z M7 12.5 L9 14.5 M10.5 9 L13.5 12 M14 5.5 L16 7.5"},
    Icon{"scale",
         "M4 13 L4 20 L11 20 L11 13 Z M4 9 L4 4 L20 4 L20 20 L15 20 M11.5 12.5 L16 8 M12.5 7.7 L16.3 7.7 L16.3 11.5"},
    Icon{"search", "O10.5 10.5 6.5 M15.5 15.5 L21 21"},
    Icon{"section", "M5 20 L5 8 L10 4 L19 4 L19 16 L14 20 Z M5 8 L14 20 M19 4 L5 20"},
    Icon{"settings", "M7 3 L7 8 M7 13 L7 21 O7 10.5 2.5 M17 3 L17 12 M17 17 L17 21 O17 14.5 2.5"},
    Icon{"smooth",
         "M3 17 L6.5 16.4 L9 14 A12 13.2 3.4 190 350 L15 14 L17.5 16.4 L21 17 M5 7.5 L19 7.5 M7.7 4.8 L5 7.5 L7.7 10.2 "
         "M16.3 4.8 L19 7.5 L16.3 10.2"},
    Icon{"snap", "M5 4 L9 4 L9 12 A12 12 3 180 0 L15 4 L19 4 L19 12 A12 12 7 0 180 Z M5 8 L9 8 M15 8 L19 8"},
    Icon{"sphere", "O12 12 8.5 M3.5 12 L7 14 L12 14.8 L17 14 L20.5 12"},
    Icon{"stereo", "M2.5 8 L2.5 16 L10 16 L11 13 L13 13 L14 16 L21.5 16 L21.5 8 Z"},
    Icon{"stop", "M8.3 3 L15.7 3 L21 8.3 L21 15.7 L15.7 21 L8.3 21 L3 15.7 L3 8.3 Z M8 12 L16 12"},
    Icon{"symmetry",
         "M12 3 L12 5.5 M12 8.5 L12 11 M12 13.5 L12 16 M12 18.5 L12 21 M8.5 6 L3 18 L8.5 18 Z M15.5 6 L21 18 L15.5 18 "
         "Z"},
    Icon{"theme", "O12 12 8.5 M12 3.5 A12 12 8.5 -90 90 F"},
    Icon{"things", "M12 3 L21 8 L12 13 L3 8 Z M3 12.3 L12 17.3 L21 12.3 M3 16.5 L12 21.5 L21 16.5"},
    Icon{"tools", "M4 20 L13 11 M11 6.5 L17.5 13 L21 9.5 L14.5 3 Z"},
    Icon{"touch",
         "M9 13.5 L9 5 A10.5 5 1.5 180 360 L12 11 L17.5 12 A17 14.5 2.5 -80 0 L18.5 18 L16.5 21.5 L10.5 21.5 L5 15 A6 "
         "13.7 1.6 140 290 L9 15.5"},
    Icon{"trash",
         "M4 6.5 L20 6.5 M9 6.5 L9 3.5 L15 3.5 L15 6.5 M6 6.5 L7 20.5 L17 20.5 L18 6.5 M10 10 L10 17 M14 10 L14 17"},
    Icon{"undo", "M4.5 9.5 L15 9.5 A15 14.5 5 -90 90 L9 19.5 M8.5 5.5 L4.5 9.5 L8.5 13.5"},
    Icon{"up", "M5 16 L12 9 L19 16"},
    Icon{"view", "M3 7 L8 7 L9.5 4.5 L14.5 4.5 L16 7 L21 7 L21 19 L3 19 Z O12 13 3.8"},
    Icon{"warning", "M12 3.5 L21.5 20 L2.5 20 Z M12 9.5 L12 14.5 D12 17.2 1.2"},
    Icon{"xray", "M3 9 L15 9 L15 21 L3 21 Z M9 6 L9 3 L21 3 L21 15 L18 15 M9 11.5 L9 13 M9 15 L12 15"},
    Icon{"airbrush",
         "M12 9 L20 9 L20 21 L12 21 Z M14 9 L14 5.5 L18 5.5 L18 9 M12 13 L20 13 D9.5 6 1.1 D6 3.8 1.1 D6 8.2 1.1 D2.5 "
         "2 1 D2.5 6 1 D2.5 10 1"},
    Icon{"blend", "O9 12 6 O15 12 6"},
    Icon{"blur_mask", "M3 7 L21 7 L20 14 L15 18 L12 15 L9 18 L4 14 Z M7 11 L17 11"},
    Icon{"burn", "M12 3 L16 10 A12 15 5.5 -30 210 L9 9 L11 11 Z"},
    Icon{"construct", "M2.5 20.5 L21.5 20.5 M5.5 20.5 A12 20.5 6.5 180 360 M12 2.5 L12 10 M8.25 6.25 L15.75 6.25"},
    Icon{"crease", "M2.5 11 L8.5 12 L12 21 L15.5 12 L21.5 11 M12 2.5 L12 8.5 M9.3 6 L12 8.7 L14.7 6"},
    Icon{"emboss", "M3 4 L21 4 L21 20 L3 20 Z M6 17 L10 10 L13 14 L15 12 L18 17 Z O16 8 1.5"},
    Icon{"fill", "M3 12 L7 12 L10 18 L14 18 L17 12 L21 12 M12 4 L12 14 M9 11 L12 14 L15 11"},
    Icon{"flatten", "M3 18 L21 18 M6 14 L18 14 M12 4 L12 10 M9 7.5 L12 10.5 L15 7.5"},
    Icon{"groove", "M3 9 L7 9 A12 9 5 0 180 M17 9 L21 9 M12 3 L12 10 M9.5 7.5 L12 10 L14.5 7.5"},
    Icon{"inflate", "A12 18 7 180 360 M3 18 L5 18 M19 18 L21 18 M12 8 L12 3 M17 10 L20.5 6.5 M7 10 L3.5 6.5"},
    Icon{"invisible", "M3 12 L7.5 8 L12 7 L16.5 8 L21 12 L16.5 16 L12 17 L7.5 16 Z M4 20 L20 4"},
    Icon{"layer", "M3 19 L7 19 L7 14 L17 14 L17 19 L21 19 M7 9 L17 9"},
    Icon{"mask", "M3 7 L21 7 L20 14 L15 18 L12 15 L9 18 L4 14 Z O8 11 1.6 O16 11 1.6"},
    Icon{"melt", "M3 4.5 L21 4.5 L21 9 A18.5 9 2.5 0 180 L16 16.5 A13 16.5 3 0 180 L10 11 A6.5 11 3.5 0 180 Z"},
    Icon{"morph",
         "M2.5 20.5 L6 20.5 A12 20.5 6 180 360 L21.5 20.5 M18.6 8.6 A12 11 7 -20 -180 M2 8.2 L5 11.4 L8.2 8.4"},
    Icon{"paint", "M14 3 L21 10 L13 14 L10 11 Z M10 11 L4 15 L3 21 L9 20 L13 14"},
    Icon{"pinch", "M3 12 L9 12 M6.5 9.5 L9 12 L6.5 14.5 M21 12 L15 12 M17.5 9.5 L15 12 L17.5 14.5 M12 4 L12 20"},
    Icon{"polish", "M3 18 A12 30 15 233 307 M8 10 L16 10 M6 13 L18 13 M19 4 L19 8 M17 6 L21 6"},
    Icon{"ridge", "M3 16 L7 16 A12 16 5 180 360 M17 16 L21 16 M12 8 L12 3 M9.5 5.5 L12 3 L14.5 5.5"},
    Icon{"scrape", "M3 18 L21 18 M5 7 L15 15 L18 12 L8 4 Z"},
    Icon{"smudge", "M3 6.5 L13 6.5 M3 12 L20 12 M3 17.5 L13 17.5 M16.5 8 L20.5 12 L16.5 16"},
    Icon{"squirt", "M4 5 L12 5 L15 9 L12 13 L4 13 Z M15 9 L18 9 D20 12 1.3 D19 16 1.3 D21 19 1.3"},
    Icon{"stamp", "M9 3 L15 3 L14 11 L18 11 L18 16 L6 16 L6 11 L10 11 Z M4 20 L20 20"},
    Icon{"stamp_paint",
         "M9 3 L15 3 L14 11 L18 11 L18 16 L6 16 L6 11 L10 11 Z D5 20.3 1.6 D9.7 20.3 1.6 D14.4 20.3 1.6 D19 20.3 1.6"},
    Icon{"straight", "M5 19 L19 5 M2.5 16.5 L7.5 21.5 M16.5 2.5 L21.5 7.5"},
    Icon{"tug", "M3 19 L7 19 A12 13 6 150 330 L21 19 M12 8 L19 3 M15 3 L19 3 L18.5 7"},
    Icon{"twist", "A12 12 8 20 160 M3.5 12.5 L4.5 15 L7 14 A12 12 8 200 340 M20.5 11.5 L19.5 9 L17 10"},
    Icon{"wax", "M2.5 20.5 L6 20 L9 17.5 L12 16.3 L15 17.5 L18 20 L21.5 20.5 M12 2 L15.2 8 A12 9.4 3.5 -25 205 Z"},
};

struct Step {
  char what = 0;  // a letter of the text
  std::array<float, 5> numbers{};
};
using Drawing = std::vector<Step>;

Drawing read(const char* path) {
  constexpr size_t kMost = 100;
  Drawing drawing;
  for (const char* at = path; *at && drawing.size() < kMost;) {
    if (std::isalpha(static_cast<unsigned char>(*at))) {
      Step& step = drawing.emplace_back();
      step.what = *at++;
      char* end = nullptr;
      for (float& number : step.numbers) {
        number = std::strtof(at, &end);
        if (end == at) break;
        number = std::clamp(number, -1000.0f, 1000.0f);
        at = end;
      }
    } else {
      ++at;
    }
  }
  return drawing;
}

// Read once: a picture of the panels has a hundred icons.
const Drawing* find(std::string_view name) {
  static const auto drawings = [] {
    std::unordered_map<std::string_view, Drawing> all;
    for (const Icon& icon : kIcons) all.emplace(icon.name, read(icon.path));
    return all;
  }();
  if (!name.empty() && std::isupper(static_cast<unsigned char>(name[0]))) {
    static std::unordered_map<std::string, Drawing> brought;
    const auto [own, fresh] = brought.try_emplace(std::string(name));
    if (fresh) own->second = read(own->first.c_str());
    return &own->second;
  }
  const auto drawing = drawings.find(name);
  return drawing == drawings.end() ? nullptr : &drawing->second;
}

}  // namespace

bool hasIcon(std::string_view name) {
  return find(name) != nullptr;
}

bool drawIcon(ImDrawList& list, std::string_view name, ImVec2 centre, float size, ImU32 colour) {
  const Drawing* drawing = find(name);
  if (!drawing) return false;
  constexpr float kRadian = std::numbers::pi_v<float> / 180;
  const float unit = size / 24, width = std::max(1.1f, 1.75f * unit);
  const auto stroke = [&](bool closed) {
    if (list._Path.Size > 1)
      list.PathStroke(colour, closed ? ImDrawFlags_Closed : 0, width);
    else
      list.PathClear();
  };
  for (const auto& [what, n] : *drawing) {
    const ImVec2 place(centre.x + (n[0] - 12) * unit, centre.y + (n[1] - 12) * unit);
    if (what == 'M' || what == 'O' || what == 'D') stroke(false);
    if (what == 'M' || what == 'L') list.PathLineTo(place);
    if (what == 'A') list.PathArcTo(place, n[2] * unit, n[3] * kRadian, n[4] * kRadian, 0);
    if (what == 'Z') stroke(true);
    if (what == 'F') list.PathFillConvex(colour);
    if (what == 'O') list.AddCircle(place, n[2] * unit, colour, 0, width);
    if (what == 'D') list.AddCircleFilled(place, n[2] * unit, colour);
  }
  stroke(false);
  return true;
}

}  // namespace argil::studio
