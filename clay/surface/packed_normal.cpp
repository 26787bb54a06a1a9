// Unit vectors in 32 bits: folded onto an octahedron, whose lower half lies around the upper one in a square.

#include <algorithm>
#include <cmath>

#include "clay/surface/surface.h"

namespace argil::clay {

PackedNormal PackedNormal::pack(const Vec3f& n) noexcept {
  const float scale = 1.0f / (std::abs(n.x()) + std::abs(n.y()) + std::abs(n.z()));
  float u = n.x() * scale, v = n.y() * scale;
  if (n.z() < 0) {
    const float folded = (1 - std::abs(v)) * (u < 0 ? -1.0f : 1.0f);
    v = (1 - std::abs(u)) * (v < 0 ? -1.0f : 1.0f);
    u = folded;
  }
  const auto fixed = [](float x, float most) { return static_cast<int>(x * most + (x < 0 ? -0.5f : 0.5f)); };
  // Even, and no −32768, which readers take for −32767.
  return {static_cast<int16_t>(fixed(u, 32767)),
          static_cast<int16_t>(2 * std::clamp(fixed(v, 16383.5f), -16383, 16383))};
}

Vec3f PackedNormal::unpack() const noexcept {
  const float x = static_cast<float>(u) / 32767.0f, y = static_cast<float>(v) / 32767.0f;
  Vec3f n(x, y, 1 - std::abs(x) - std::abs(y));
  if (n.z() < 0) {
    n.x() = (1 - std::abs(y)) * (x < 0 ? -1.0f : 1.0f);
    n.y() = (1 - std::abs(x)) * (y < 0 ? -1.0f : 1.0f);
  }
  return n.normalized();
}

}  // namespace argil::clay
