#include "io/models/colour_list.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <tuple>

namespace argil::io {

namespace {

constexpr float kNone = -1;  ///< In place of red: no colour was given.

}  // namespace

void ColourList::add(size_t index, std::span<const double> numbers) {
  colours_.resize(index, {kNone, 0, 0, 0});
  std::array<float, 4>& colour = colours_.emplace_back(std::array<float, 4>{0, 0, 0, kNone});
  for (size_t i = 0; i < std::min<size_t>(numbers.size(), 4); ++i) {
    const double part = std::isfinite(numbers[i]) ? std::clamp(numbers[i], 0.0, 255.0) : 0.0;
    largest_ = std::max(largest_, part);
    colour[i] = static_cast<float>(part);
  }
}

std::vector<Colour> ColourList::take(size_t count) {
  std::vector<Colour> result;
  if (!colours_.empty()) {
    const float scale = largest_ > 1 ? 1.0f : 255.0f;
    const auto part = [scale](float number) { return static_cast<uint8_t>(number * scale + 0.5f); };
    result.resize(count);
    for (size_t i = 0; i < std::min(count, colours_.size()); ++i) {
      const auto& [red, green, blue, alpha] = colours_[i];
      if (red != kNone) result[i] = {part(red), part(green), part(blue), alpha == kNone ? uint8_t{255} : part(alpha)};
    }
  }
  *this = {};
  return result;
}

void setCornerColours(ModelObject& object, std::span<const std::array<Colour, 3>> corners) {
  object.vertexColours.clear();
  object.triangleColours.clear();
  const auto isPlain = [](const std::array<Colour, 3>& c) { return c[0] == c[1] && c[0] == c[2]; };
  if (std::all_of(corners.begin(), corners.end(), isPlain)) {
    object.triangleColours.reserve(corners.size());
    for (const auto& each : corners) object.triangleColours.push_back(each[0]);
    return;
  }
  std::vector<Colour>& colours = object.vertexColours;
  colours.resize(object.mesh.positions.size());
  std::vector<bool> taken(colours.size());
  // Further vertices at the place of one whose first colour is another.
  std::map<std::tuple<uint32_t, uint8_t, uint8_t, uint8_t, uint8_t>, uint32_t> more;
  for (size_t t = 0; t < corners.size(); ++t) {
    for (size_t k = 0; k < 3; ++k) {
      uint32_t& vertex = object.mesh.triangles[t][k];
      const Colour& colour = corners[t][k];
      if (!taken[vertex]) {
        colours[vertex] = colour;
        taken[vertex] = true;
      }
      if (colours[vertex] == colour) continue;
      const auto [at, isNew] = more.try_emplace({vertex, colour.red, colour.green, colour.blue, colour.alpha},
                                                uint32_t(object.mesh.positions.size()));
      if (isNew) {
        object.mesh.positions.push_back(Vec3d(object.mesh.positions[vertex]));
        colours.push_back(colour);
        taken.push_back(true);
      }
      vertex = at->second;
    }
  }
}

}  // namespace argil::io
