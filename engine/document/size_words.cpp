#include "engine/document/size_words.h"

#include <fmt/format.h>

namespace argil::engine {

std::string sizeWords(const Vec3d& s) {
  const auto figure = [](double mm) { return mm >= 1000 ? fmt::format("{:.0f}", mm) : fmt::format("{:.4g}", mm); };
  return fmt::format("{} × {} × {} mm", figure(s.x()), figure(s.y()), figure(s.z()));
}

}  // namespace argil::engine
