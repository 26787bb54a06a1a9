#include "engine/document/size_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace argil::engine {

std::string sizeWords(const Vec3d& s) {
  const auto figure = [](double mm) { return mm >= 1000 ? fmt::format("{:.0f}", mm) : fmt::format("{:.4g}", mm); };
  return fmt::format("{} × {} × {} mm", figure(s.x()), figure(s.y()), figure(s.z()));
}

std::string figure(double value, int digits) {
  if (!std::isfinite(value)) return "–";
  const double size = std::abs(value);
  constexpr int kMostBehind = 12;
  const int before = size > 0 ? static_cast<int>(std::floor(std::log10(size))) + 1 : 1;
  std::string text = fmt::format("{:.{}f}", value, std::clamp(digits - before, 0, kMostBehind));
  if (text.find('.') != std::string::npos) {
    text.erase(text.find_last_not_of('0') + 1);
    if (text.back() == '.') text.pop_back();
  }
  return text == "-0" ? "0" : text;
}

std::string counted(double count) {
  if (count >= 1e9) return fmt::format("{:.3g} G", count * 1e-9);
  if (count >= 1e6) return fmt::format("{:.3g} M", count * 1e-6);
  if (count >= 1e3) return fmt::format("{:.3g} k", count * 1e-3);
  return fmt::format("{:.0f}", count);
}

}  // namespace argil::engine
