#include "ui3d/studio/kit/theme.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>

namespace argil::studio {
namespace {

constexpr ImU32 rgb(unsigned hex) {
  return IM_COL32((hex >> 16) & 255, (hex >> 8) & 255, hex & 255, 255);
}

constexpr Colours kDark{.panel = rgb(0x25272b),
                        .bar = rgb(0x1d1f22),
                        .field = rgb(0x33363c),
                        .fieldHover = rgb(0x3d4148),
                        .fieldPress = rgb(0x41454c),
                        .line = rgb(0x3a3d43),
                        .text = rgb(0xe8e9eb),
                        .dim = rgb(0xb0b4bb),
                        .accent = rgb(0x74b6e2),
                        .onAccent = rgb(0x0b1a25),
                        .soft = rgb(0x2b3d4c),
                        .level = rgb(0x31485a),
                        .good = rgb(0x7fce93),
                        .warning = rgb(0xf0bd5e),
                        .error = rgb(0xff938a),
                        .stop = rgb(0xc62f28),
                        .onStop = rgb(0xffffff)};
constexpr Colours kLight{.panel = rgb(0xf6f6f5),
                         .bar = rgb(0xe9e9e7),
                         .field = rgb(0xffffff),
                         .fieldHover = rgb(0xefeeec),
                         .fieldPress = rgb(0xe2e0dd),
                         .line = rgb(0xcfcfcc),
                         .text = rgb(0x1f2124),
                         .dim = rgb(0x565a61),
                         .accent = rgb(0x1f6591),
                         .onAccent = rgb(0xffffff),
                         .soft = rgb(0xd3e4f0),
                         .level = rgb(0xb9d5e8),
                         .good = rgb(0x1d6b35),
                         .warning = rgb(0x7d5200),
                         .error = rgb(0xb3221b),
                         .stop = rgb(0xc62f28),
                         .onStop = rgb(0xffffff)};

Theme inForce = Theme::dark;
float scaleInForce = 1;
Fonts fontsInForce;

double linear(unsigned channel) {
  const double c = channel / 255.0;
  return c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
}
double luminance(ImU32 colour) {
  return 0.2126 * linear((colour >> IM_COL32_R_SHIFT) & 255) + 0.7152 * linear((colour >> IM_COL32_G_SHIFT) & 255) +
         0.0722 * linear((colour >> IM_COL32_B_SHIFT) & 255);
}

// What people's file names and our texts need: Latin, Greek, Cyrillic, punctuation, ², arrows, mathematical signs.
constexpr std::array<ImWchar, 17> kLetters{0x20,   0x17f,  0x370,  0x3ff,  0x400,  0x45f,  0x2009, 0x2033, 0x2070,
                                           0x2089, 0x2190, 0x2199, 0x2212, 0x221e, 0x2248, 0x2265, 0};
constexpr std::array<ImWchar, 3> kTitleLetters{0x20, 0xff, 0};

ImFont* addFont(const std::string& file, float units, const ImWchar* letters, float scale) {
  ImFontAtlas& atlas = *ImGui::GetIO().Fonts;
  ImFontConfig config;
  config.SizePixels = std::round(units * scale);
  config.OversampleH = scale < 1.6f ? 2 : 1;
  config.OversampleV = 1;
  config.PixelSnapH = true;
  if (file.empty()) return atlas.AddFontDefault(&config);
  return atlas.AddFontFromFileTTF(file.c_str(), config.SizePixels, &config, letters);
}

void setColours(const Colours& c) {
  ImGuiStyle& style = ImGui::GetStyle();
  const auto set = [&](ImGuiCol index, ImU32 colour, float alpha = 1) {
    ImVec4 value = ImGui::ColorConvertU32ToFloat4(colour);
    value.w *= alpha;
    style.Colors[index] = value;
  };
  for (int i = 0; i < ImGuiCol_COUNT; ++i) set(i, c.field);
  set(ImGuiCol_Text, c.text);
  set(ImGuiCol_TextDisabled, c.dim);
  set(ImGuiCol_WindowBg, c.panel);
  set(ImGuiCol_ChildBg, c.panel, 0);
  set(ImGuiCol_PopupBg, c.panel);
  set(ImGuiCol_Border, c.line);
  set(ImGuiCol_BorderShadow, c.line, 0);
  set(ImGuiCol_FrameBg, c.field);
  set(ImGuiCol_FrameBgHovered, c.fieldHover);
  set(ImGuiCol_FrameBgActive, c.fieldPress);
  set(ImGuiCol_MenuBarBg, c.bar);
  set(ImGuiCol_ScrollbarBg, c.panel, 0);
  set(ImGuiCol_ScrollbarGrab, c.dim, 0.35f);
  set(ImGuiCol_ScrollbarGrabHovered, c.dim, 0.6f);
  set(ImGuiCol_ScrollbarGrabActive, c.dim, 0.8f);
  set(ImGuiCol_CheckMark, c.accent);
  set(ImGuiCol_Header, c.soft);
  set(ImGuiCol_HeaderHovered, c.fieldHover);
  set(ImGuiCol_HeaderActive, c.fieldPress);
  set(ImGuiCol_Separator, c.line);
  set(ImGuiCol_TextSelectedBg, c.level);
  set(ImGuiCol_DragDropTarget, c.accent);
  set(ImGuiCol_NavHighlight, c.accent, 0);
  set(ImGuiCol_ModalWindowDimBg, IM_COL32(0, 0, 0, 255), kDimming);
}

}  // namespace

const Colours& coloursOf(Theme theme) {
  return theme == Theme::dark ? kDark : kLight;
}
const Colours& colours() {
  return coloursOf(inForce);
}
const Fonts& fonts() {
  return fontsInForce;
}
float pixelScale() {
  return scaleInForce;
}

double contrast(ImU32 a, ImU32 b) {
  const double la = luminance(a), lb = luminance(b);
  return (std::max(la, lb) + 0.05) / (std::min(la, lb) + 0.05);
}

std::vector<TextPair> textPairs(Theme theme) {
  const Colours& c = coloursOf(theme);
  std::vector<TextPair> pairs;
  for (const auto& [name, ground] : {std::pair{"panel", c.panel},
                                     {"bar", c.bar},
                                     {"field", c.field},
                                     {"hovered", c.fieldHover},
                                     {"pressed", c.fieldPress}}) {
    pairs.push_back({name, c.text, ground});
    pairs.push_back({name, c.dim, ground});
  }
  pairs.push_back({"chosen row", c.text, c.soft});
  pairs.push_back({"chosen row, dim", c.dim, c.soft});
  pairs.push_back({"slider", c.text, c.level});
  pairs.push_back({"accent", c.onAccent, c.accent});
  pairs.push_back({"stop", c.onStop, c.stop});
  for (const ImU32 ground : {c.panel, c.bar}) {
    for (const ImU32 text : {c.good, c.warning, c.error, c.accent}) pairs.push_back({"message", text, ground});
  }
  return pairs;
}

std::string fontFile(bool strong) {
  static constexpr std::array<std::array<const char*, 2>, 5> kFiles{{
      {"/usr/share/fonts/opentype/inter/Inter-Regular.otf", "/usr/share/fonts/opentype/inter/Inter-SemiBold.otf"},
      {"/usr/share/fonts/truetype/inter/Inter-Regular.ttf", "/usr/share/fonts/truetype/inter/Inter-SemiBold.ttf"},
      {"/usr/share/fonts/truetype/liberation2/LiberationSans-Regular.ttf",
       "/usr/share/fonts/truetype/liberation2/LiberationSans-Bold.ttf"},
      {"/usr/share/fonts/truetype/liberation/LiberationSans-Regular.ttf",
       "/usr/share/fonts/truetype/liberation/LiberationSans-Bold.ttf"},
      {"/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf", "/usr/share/fonts/truetype/dejavu/DejaVuSans-Bold.ttf"},
  }};
  for (const auto& [regular, bold] : kFiles) {
    std::error_code ignored;
    if (std::filesystem::exists(regular, ignored) && std::filesystem::exists(bold, ignored))
      return strong ? bold : regular;
  }
  return {};
}

void applyTheme(Theme theme, float scale) {
  inForce = theme;
  scaleInForce = scale;
  ImGuiIO& io = ImGui::GetIO();
  io.Fonts->Clear();
  const std::string regular = fontFile(false), strong = fontFile(true);
  fontsInForce.body = addFont(regular, kTextSize, kLetters.data(), scale);
  fontsInForce.strong = addFont(strong, kTextSize, kLetters.data(), scale);
  fontsInForce.small = addFont(regular, kSmallSize, kLetters.data(), scale);
  fontsInForce.title = addFont(strong, kTitleSize, kTitleLetters.data(), scale);
  io.Fonts->Build();
  io.FontGlobalScale = 1 / scale;  // Drawn in interface units from letters of the window's pixels.
  io.IniFilename = nullptr;

  ImGuiStyle& style = ImGui::GetStyle();
  style = ImGuiStyle();
  style.WindowPadding = {kPad, kPad};
  style.FramePadding = {9, 5};
  style.ItemSpacing = {kGap, kGap};
  style.ItemInnerSpacing = {kGap, kGap};
  style.CellPadding = {4, 3};
  style.WindowRounding = 0;
  style.ChildRounding = style.FrameRounding = style.PopupRounding = style.GrabRounding = kRound;
  style.ScrollbarRounding = 4;
  style.ScrollbarSize = 9;
  style.WindowBorderSize = 0;
  style.PopupBorderSize = 1;
  style.ChildBorderSize = style.FrameBorderSize = 0;
  style.WindowMinSize = {1, 1};
  style.DisabledAlpha = 0.45f;
  style.CurveTessellationTol = 1.25f / scale;
  style.CircleTessellationMaxError = 0.3f / scale;
  setColours(coloursOf(theme));
}

}  // namespace argil::studio
