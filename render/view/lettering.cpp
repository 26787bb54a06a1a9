#include "render/view/lettering.h"

#include <cstdint>

namespace argil::render {
namespace {

/// Polylines on a grid 4 wide and 8 high: capitals from y 0 to 6, small letters from 2, descenders to 8. Two digits a
/// point, a blank lifts the pen.
struct Glyph {
  uint32_t code;
  float width;
  const char* path;
};

constexpr Glyph kGlyphs[] = {
    {'0', 4, "103041453616050110"},
    {'1', 2, "011016 0626"},
    {'2', 4, "01103041420646"},
    {'3', 4, "0110304142334445361605 1333"},
    {'4', 4, "36300444"},
    {'5', 4, "4000033344453606"},
    {'6', 4, "4130100105163645443303"},
    {'7', 4, "004016"},
    {'8', 4, "103041423313020110 1304051636454433"},
    {'9', 4, "0516364541301001021343"},
    {'.', 0, "0606"},
    {'-', 3, "0333"},
    {'m', 6, "0206 0312223336 3342526366"},
    {0xb5, 4, "0208 05163645 4246"},
    {'g', 4, "4247381807 4332120305163645"},
    {'r', 3, "0206 041232"},
    {'i', 0, "0206 0000"},
    {'d', 4, "4046 4332120305163645"},
};

constexpr float kGap = 1.6f, kBlank = 2.2f, kRows = 6;

const Glyph* find(uint32_t code) {
  for (const Glyph& glyph : kGlyphs) {
    if (glyph.code == code) return &glyph;
  }
  return nullptr;
}

uint32_t nextCode(std::string_view text, size_t& at) {
  const auto byte = [&](size_t i) { return uint32_t(static_cast<unsigned char>(text[i])); };
  const uint32_t first = byte(at++);
  if (first < 0x80) return first;
  uint32_t code = first & 0x1f;
  while (at < text.size() && (byte(at) & 0xc0) == 0x80) code = (code << 6) | (byte(at++) & 0x3f);
  return code;
}

}  // namespace

std::vector<Stroke2> letter(std::string_view text, float x, float y, float height) {
  std::vector<Stroke2> strokes;
  const float unit = height / kRows;
  for (size_t at = 0; at < text.size();) {
    const Glyph* glyph = find(nextCode(text, at));
    if (!glyph) {
      x += (kBlank + kGap) * unit;
      continue;
    }
    bool down = false;
    float px = 0, py = 0;
    for (const char* c = glyph->path; *c;) {
      if (*c == ' ') {
        down = false;
        ++c;
        continue;
      }
      const float nx = x + float(c[0] - '0') * unit, ny = y + float(c[1] - '0') * unit;
      if (down) strokes.push_back({px, py, nx, ny});
      px = nx;
      py = ny;
      down = true;
      c += 2;
    }
    x += (glyph->width + kGap) * unit;
  }
  return strokes;
}

float letterWidth(std::string_view text, float height) {
  float width = 0;
  for (size_t at = 0; at < text.size();) {
    const Glyph* glyph = find(nextCode(text, at));
    width += (glyph ? glyph->width : kBlank) + kGap;
  }
  return (width > 0 ? width - kGap : 0) * height / kRows;
}

}  // namespace argil::render
