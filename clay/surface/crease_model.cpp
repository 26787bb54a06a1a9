#include "clay/surface/crease_model.h"

#include <algorithm>
#include <cmath>

namespace argil::clay {

void CreaseModel::findTurns() {
  for (size_t a = 0; a < static_cast<size_t>(count); ++a)
    for (size_t b = 0; b < static_cast<size_t>(count); ++b)
      convex[a][b] = a != b && face[a].at(face[b].foot) + face[b].at(face[a].foot) < 0;
}

float CreaseModel::at(const Vec3f& p) const {
  return joined({face[0].at(p), face[1].at(p), count == 3 ? face[2].at(p) : 0});
}

float CreaseModel::joined(const std::array<float, 3>& d) const {
  const auto join = [](float a, float b, bool isConvex) { return isConvex ? std::max(a, b) : std::min(a, b); };
  if (count == 2) return join(d[0], d[1], convex[0][1]);
  // The pair that is unlike the other two first.
  if (convex[0][1] == convex[0][2]) return join(d[0], join(d[1], d[2], convex[1][2]), convex[0][1]);
  if (convex[0][1] == convex[1][2]) return join(d[1], join(d[0], d[2], convex[0][2]), convex[0][1]);
  return join(d[2], join(d[0], d[1], convex[0][1]), convex[0][2]);
}

float CreaseModel::distance(const Vec3f& p) const {
  // The nearest of the points on planes, lines and the corner that are on the surface.
  constexpr float kOn = 1e-3f;
  float best2 = 1e9f;
  const auto offer = [&](const Vec3f& q) {
    if (std::abs(at(q)) < kOn) best2 = std::min(best2, (q - p).squaredNorm());
  };
  for (int a = 0; a < count; ++a) {
    offer(face[static_cast<size_t>(a)].nearest(p));
    for (int b = a + 1; b < count; ++b)
      if (const std::optional<Line> between = line(a, b, p)) offer(between->start);
  }
  if (count == 3)
    if (const std::optional<Vec3f> tip = corner()) offer(*tip);
  return std::sqrt(best2);
}

std::optional<CreaseModel::Line> CreaseModel::line(int a, int b, const Vec3f& p) const {
  const Face &fa = face[static_cast<size_t>(a)], &fb = face[static_cast<size_t>(b)];
  const Vec3f along = fa.gradient.cross(fb.gradient);
  const float length2 = along.squaredNorm();
  if (length2 < 0.02f) return std::nullopt;  // 8°
  // p + α ga + β gb, on both planes.
  const float aa = fa.gradient.squaredNorm(), bb = fb.gradient.squaredNorm(), ab = fa.gradient.dot(fb.gradient);
  const float da = fa.at(p), db = fb.at(p);
  return Line{p + ((ab * db - bb * da) / length2) * fa.gradient + ((ab * da - aa * db) / length2) * fb.gradient,
              along * (1 / std::sqrt(length2))};
}

float CreaseModel::sideOfThird(int a, int b) const {
  const int c = 3 - a - b;
  if (convex[a][c] == convex[b][c]) return convex[a][c] ? -1.0f : 1.0f;
  return convex[a][b] ? 1.0f : -1.0f;
}

std::optional<Vec3f> CreaseModel::corner() const {
  const auto& [a, b, c] = face;
  const Vec3f bc = b.gradient.cross(c.gradient), ca = c.gradient.cross(a.gradient), ab = a.gradient.cross(b.gradient);
  const float det = a.gradient.dot(bc);
  if (std::abs(det) < 0.1f) return std::nullopt;
  return Vec3f((-1 / det) * (a.offset * bc + b.offset * ca + c.offset * ab));
}

}  // namespace argil::clay
