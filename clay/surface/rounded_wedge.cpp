#include "clay/surface/rounded_wedge.h"

#include <algorithm>
#include <cmath>

namespace argil::clay {

namespace {
constexpr float kBehind = 1e-4f;
}  // namespace

std::optional<RoundedWedge> RoundedWedge::of(const CreaseModel& model) {
  RoundedWedge wedge;
  wedge.count_ = model.count;
  const bool convex = model.convex[0][1];
  if (model.count == 3 && (model.convex[0][2] != convex || model.convex[1][2] != convex)) return std::nullopt;
  wedge.turn_ = convex ? 1.0f : -1.0f;
  for (size_t k = 0; k < static_cast<size_t>(model.count); ++k) {
    const float scale = wedge.turn_ / std::sqrt(model.face[k].gradient.squaredNorm());
    wedge.normal_[k] = scale * model.face[k].gradient;
    wedge.offset_[k] = scale * model.face[k].offset;
    for (size_t j = 0; j <= k; ++j) wedge.cosine_[k][j] = wedge.cosine_[j][k] = wedge.normal_[k].dot(wedge.normal_[j]);
  }
  return wedge;
}

size_t RoundedWedge::farthest(const std::array<float, 3>& d) const {
  size_t most = 0;
  for (size_t k = 1; k < static_cast<size_t>(count_); ++k)
    if (d[k] > d[most]) most = k;
  return most;
}

bool RoundedWedge::alone(const std::array<float, 3>& d, size_t most) const {
  for (size_t j = 0; j < static_cast<size_t>(count_); ++j)
    if (j != most && !(d[j] - cosine_[j][most] * d[most] <= kBehind)) return false;
  return true;
}

RoundedWedge::Value RoundedWedge::given(float distance, const Vec3f& gradient, float byRadius) const {
  return {turn_ * (distance - radius_), gradient * turn_, turn_ * (byRadius - 1)};
}

// The nearest point of the faces moved in by the radius: on one of them, on the line of two, or at the tip; first where
// the others lie behind.
RoundedWedge::Value RoundedWedge::at(const Vec3f& p) const {
  std::array<float, 3> d{};
  for (size_t k = 0; k < static_cast<size_t>(count_); ++k) d[k] = normal_[k].dot(p) + offset_[k] + radius_;
  const size_t most = farthest(d);
  return d[most] <= 0 || alone(d, most) ? given(d[most], normal_[most], 1) : between(d, most);
}

RoundedWedge::Value RoundedWedge::between(const std::array<float, 3>& d, size_t most) const {
  const auto& c = cosine_;
  const auto n = static_cast<size_t>(count_);
  const auto behind = [&](size_t k, float others) { return d[k] - others <= kBehind; };
  for (size_t a = 0; a < n; ++a)
    for (size_t b = 0; b < a; ++b) {
      const float det = 1 - c[a][b] * c[a][b];
      if (det < 1e-4f) continue;
      const float wa = (d[a] - c[a][b] * d[b]) / det, wb = (d[b] - c[a][b] * d[a]) / det;
      if (wa < 0 || wb < 0) continue;
      const size_t third = 3 - a - b;
      if (n == 3 && !behind(third, wa * c[third][a] + wb * c[third][b])) continue;
      const float distance = std::sqrt(std::max(1e-12f, wa * d[a] + wb * d[b]));
      return given(distance, (wa * normal_[a] + wb * normal_[b]) * (1 / distance), (wa + wb) / distance);
    }
  if (n == 2) return given(d[most], normal_[most], 1);
  const Vec3f bc = normal_[1].cross(normal_[2]), ca = normal_[2].cross(normal_[0]), ab = normal_[0].cross(normal_[1]);
  const float det = normal_[0].dot(bc);
  if (std::abs(det) < 0.05f) return given(d[most], normal_[most], 1);
  const Vec3f out = (1 / det) * (d[0] * bc + d[1] * ca + d[2] * ab);  // from the tip to p
  const float distance = std::sqrt(std::max(1e-12f, out.squaredNorm()));
  const Vec3f gradient = out * (1 / distance);
  // Moving every face by one moves the tip by (bc + ca + ab) / det.
  return given(distance, gradient, gradient.dot(bc + ca + ab) / det);
}

void RoundedWedge::fit(const CellView& cell) {
  // The voxels around the cell, and how far from the faces as they are, without a radius.
  struct Sample {
    float phi;
    std::array<float, 3> d{};
  };
  std::array<Sample, 64> samples;
  size_t count = 0;
  for (int x = -1; x <= 2; ++x)
    for (int y = -1; y <= 2; ++y)
      for (int z = -1; z <= 2; ++z) {
        const float phi = cell.phi[x * cell.stepX + y * cell.stepY + z];
        if (std::abs(phi) > 2.0f) continue;
        Sample& sample = samples[count++];
        const Vec3f p = cell.low + Vec3f(static_cast<float>(x), static_cast<float>(y), static_cast<float>(z));
        sample.phi = phi;
        for (size_t k = 0; k < static_cast<size_t>(count_); ++k) sample.d[k] = normal_[k].dot(p) + offset_[k];
      }
  radius_ = 0.3f;
  for (int round = 0; round < 5; ++round) {
    float top = 0, bottom = 1e-6f;
    for (size_t i = 0; i < count; ++i) {
      // On one face alone the radius changes nothing.
      std::array<float, 3> d = samples[i].d;
      for (float& each : d) each += radius_;
      const size_t most = farthest(d);
      if (d[most] <= 0 || alone(d, most)) continue;
      const Value v = between(d, most);
      top += v.byRadius * (samples[i].phi - v.distance);
      bottom += v.byRadius * v.byRadius;
    }
    const float next = std::clamp(radius_ + top / bottom, 0.0f, kMostRadius);
    if (bottom < 1e-3f) {
      radius_ = 0;
      return;
    }
    if (next == radius_) return;
    radius_ = next;
  }
}

float RoundedWedge::misfit(const CellView& cell) const {
  float most = 0;
  for (int c = 0; c < 8; ++c) {
    const Value v =
        at(cell.low + Vec3f(static_cast<float>(c >> 2), static_cast<float>((c >> 1) & 1), static_cast<float>(c & 1)));
    most = std::max(most, std::abs(v.distance - cell.corner(c)));
  }
  return most;
}

}  // namespace argil::clay
