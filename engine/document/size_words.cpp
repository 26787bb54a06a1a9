#include "engine/document/size_words.h"

#include <fmt/format.h>

namespace argil::engine {

std::string sizeWords(const Vec3d& s) {
  const auto figure = [](double mm) { return mm >= 1000 ? fmt::format("{:.0f}", mm) : fmt::format("{:.4g}", mm); };
  return fmt::format("{} × {} × {} mm", figure(s.x()), figure(s.y()), figure(s.z()));
}

std::string counted(double count) {
  if (count >= 1e9) return fmt::format("{:.3g} G", count * 1e-9);
  if (count >= 1e6) return fmt::format("{:.3g} M", count * 1e-6);
  if (count >= 1e3) return fmt::format("{:.3g} k", count * 1e-3);
  return fmt::format("{:.0f}", count);
}

}  // namespace argil::engine
