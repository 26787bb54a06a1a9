#include "io/cad/cad_body.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <string_view>

#include "clay/base/error.h"

namespace argil::io {

namespace {

std::string lowered(const std::filesystem::path& file) {
  std::string ending = file.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return std::tolower(c); });
  return ending;
}

// Quads that hang together, and the volume that they bound: below zero around a cavity.
struct Shell {
  std::vector<uint32_t> quads;
  double volume = 0;
  Vec3d low = Vec3d::Constant(INFINITY), high = Vec3d::Constant(-INFINITY);
  [[nodiscard]] bool within(const Shell& other) const {
    return (low.array() >= other.low.array()).all() && (high.array() <= other.high.array()).all();
  }
};
std::vector<Shell> shellsOf(const clay::PatchSurface& surface, const clay::QuadTopology& topology) {
  std::vector<Shell> shells;
  std::vector<bool> taken(surface.patches.size());
  for (uint32_t first = 0; first < taken.size(); ++first) {
    if (taken[first]) continue;
    Shell& shell = shells.emplace_back();
    std::vector<uint32_t> todo{first};
    taken[first] = true;
    while (!todo.empty()) {
      const uint32_t f = todo.back();
      todo.pop_back();
      shell.quads.push_back(f);
      for (int s = 0; s < 4; ++s)
        for (const uint32_t next : topology.edges()[topology.edgeOf(f, s)].quad)
          if (!taken[next]) taken[next] = true, todo.push_back(next);
      const auto corner = [&](size_t s) { return surface.points[topology.quads()[f][s]]; };
      shell.volume += (corner(0).dot(corner(1).cross(corner(2))) + corner(0).dot(corner(2).cross(corner(3)))) / 6;
      for (size_t s = 0; s < 4; ++s)
        shell.low = shell.low.cwiseMin(corner(s)), shell.high = shell.high.cwiseMax(corner(s));
    }
    std::sort(shell.quads.begin(), shell.quads.end());
  }
  return shells;
}

}  // namespace

bool isStep(const std::filesystem::path& file) {
  const std::string ending = lowered(file);
  return ending == ".step" || ending == ".stp";
}

bool isIges(const std::filesystem::path& file) {
  const std::string ending = lowered(file);
  return ending == ".iges" || ending == ".igs";
}

std::vector<CadSolid> solidsOf(const clay::PatchSurface& surface, const clay::QuadTopology& topology) {
  std::vector<Shell> shells = shellsOf(surface, topology);
  std::vector<std::vector<std::vector<uint32_t>>> cavities(shells.size());
  for (const Shell& cavity : shells) {
    if (cavity.volume > 0) continue;
    size_t around = shells.size();
    for (size_t k = 0; k < shells.size(); ++k)
      if (shells[k].volume > 0 && cavity.within(shells[k]) &&
          (around == shells.size() || shells[k].volume < shells[around].volume))
        around = k;
    if (around < shells.size()) cavities[around].push_back(cavity.quads);
  }
  std::vector<CadSolid> solids;
  for (size_t k = 0; k < shells.size(); ++k)
    if (shells[k].volume > 0) solids.push_back({std::move(shells[k].quads), std::move(cavities[k])});
  return solids;
}

void appendReal(std::string& out, double value) {
  if (!std::isfinite(value)) throw Error("a surface with a number that is not finite cannot be written");
  std::array<char, 32> room{};
  const char* end = fmt::format_to_n(room.data(), room.size(), "{}", value).out;
  const std::string_view text(room.data(), size_t(end - room.data())), mantissa = text.substr(0, text.find('e'));
  out += mantissa;
  if (mantissa.find('.') == std::string_view::npos) out += '.';
  if (mantissa.size() == text.size()) return;
  out += 'E';
  out += text.substr(mantissa.size() + 1);
}

}  // namespace argil::io
