#include "clay/cage/least_near.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>
#include <map>

namespace argil::clay {

namespace {

using Cell = std::array<int64_t, 3>;

}  // namespace

std::vector<float> leastNear(const std::vector<Vec3d>& places, const std::vector<float>& values, double reach) {
  // In cells as large as the reach, whose neighbours hold all that is within it.
  const auto cellOf = [&](const Vec3d& p) {
    return Cell{std::llround(std::floor(p.x() / reach)), std::llround(std::floor(p.y() / reach)),
                std::llround(std::floor(p.z() / reach))};
  };
  std::map<Cell, float> least, around;
  for (size_t i = 0; i < places.size(); ++i) {
    const auto [it, fresh] = least.try_emplace(cellOf(places[i]), values[i]);
    if (!fresh) it->second = std::min(it->second, values[i]);
  }
  for (const auto& [cell, value] : least) {
    float& out = around[cell] = value;
    for (int k = 0; k < 27; ++k) {
      const auto it = least.find({cell[0] + k % 3 - 1, cell[1] + k / 3 % 3 - 1, cell[2] + k / 9 - 1});
      if (it != least.end()) out = std::min(out, it->second);
    }
  }
  std::vector<float> out;
  for (const Vec3d& p : places) out.push_back(around.find(cellOf(p))->second);
  return out;
}

}  // namespace argil::clay
