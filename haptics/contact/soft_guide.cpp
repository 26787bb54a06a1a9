#include "haptics/contact/soft_guide.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace argil::haptics {
namespace {

// f(s) = F s (1 − s²)² / kTop, s = |d| / R: its largest value is F, at s = 1/√5.
constexpr double kTop = 0.28621670111997307;

Pull inRange(bool within) noexcept {
  Pull none;
  none.within = none.caught = within;
  return none;
}

struct Puller {
  const Scene& scene;
  TouchableClay* clay;
  const Vec3d& at;
  const Vec3d& velocity;
  uint32_t buttons;
  const SoftLimits& limits;
  SoftMemory& memory;

  Pull operator()(const WellAtPoints& g) const noexcept {
    double best = std::numeric_limits<double>::infinity();
    Vec3d way = Vec3d::Zero();
    for (const Vec3d& p : g.points) {
      const Vec3d d = p - at;
      const double d2 = d.squaredNorm();
      if (d2 < best) best = d2, way = d;
    }
    return wellPull(way, g.shape, limits);
  }
  Pull operator()(const WellAtCurve& g) const noexcept {
    const bool known = memory.curve == g.curve->id();
    memory.place = g.curve->nearest(at, known ? &memory.place : nullptr);
    memory.curve = g.curve->id();
    return wellPull(memory.place.point - at, g.shape, limits);
  }
  Pull operator()(const WellAtPlane& g) const noexcept {
    const Vec3d n = g.normal.normalized();
    return wellPull(n * n.dot(g.point - at), g.shape, limits);
  }
  Pull operator()(const WellAtPiece& g) const noexcept {
    if (!clay || g.piece >= scene.pieces.size()) return inRange(false);
    clay->reset(scene.pieces[g.piece]);
    const double radius = scene.tool.radiusMm;
    const Nearest n = clay->nearest(at, radius + g.shape.rangeMm, memory.nearKnown ? &memory.near : nullptr);
    memory.nearKnown = n.found;
    if (!n.found) return inRange(false);
    memory.near = n.point;
    // At the surface and below it contact alone is felt.
    if (!(n.distance > radius)) return wellPull(Vec3d::Zero(), g.shape, limits);
    return wellPull((n.point - at) * ((n.distance - radius) / n.distance), g.shape, limits);
  }
  Pull steady(const Vec3d& force, double stiffness) const noexcept {
    Pull pull;
    const double size = force.norm();
    pull.force = size > limits.forceN ? Vec3d(force * (limits.forceN / size)) : force;
    pull.mostN = limits.forceN;
    pull.stiffnessNmm = stiffness;
    return pull;
  }
  Pull operator()(const Gravity& g) const noexcept { return steady(g.forceN, 0); }
  Pull operator()(const Buoyancy& g) const noexcept {
    const Vec3d up = g.up.normalized();
    const double force = std::min({g.forceN, limits.forceN, limits.stiffnessNmm * g.depthMm / 1.5});
    const double s = std::clamp(up.dot(g.levelPoint - at) / g.depthMm, 0.0, 1.0);
    return steady(up * (force * s * s * (3 - 2 * s)), 1.5 * force / g.depthMm);
  }
  Pull operator()(const Viscosity& g) const noexcept {
    const double drag = std::min(g.dragNsmm, limits.dragNsmm);
    // Its force follows the speed, whatever the way.
    return steady(-drag * velocity, std::numeric_limits<double>::infinity());
  }
  Pull operator()(const AmbientPlane& g) const noexcept {
    const Vec3d n = g.normal.normalized();
    const double k = std::min(g.stiffnessNmm, limits.stiffnessNmm), most = std::min(g.mostN, limits.forceN);
    if (!(most > 0)) return steady(Vec3d::Zero(), 0);
    const double pull = k * n.dot(g.point - at);
    return steady(n * (pull / std::sqrt(1 + pull * pull / (most * most))), k);
  }
  // Planes push by their springs alone, and springs are wells: each element is the gradient of a potential, so that
  // what stands still gives no energy. What a newer model changes at once is let go little by little, like any leap of
  // a guide.
  Pull operator()(const FollowModel& g) const noexcept {
    g.source->tell(at, velocity, buttons);
    memory.modelAgeS = g.source->newest(memory.model) ? 0 : memory.modelAgeS + limits.periodS;
    const LocalModel& model = memory.model;
    const double fresh = std::clamp(1 - (memory.modelAgeS - kModelHoldsS) / kModelFadesS, 0.0, 1.0);
    if (!(fresh > 0) || !((at - model.middle).norm() <= model.radiusMm)) return inRange(false);
    Pull pull;
    for (size_t i = 0; i < size_t(std::clamp(model.count, 0, LocalModel::kMost)); ++i) {
      const LocalModel::Element& e = model.elements[i];
      const double k = std::min(e.stiffnessNmm, limits.stiffnessNmm);
      if (e.kind == LocalModel::Element::Kind::plane) {
        const double behind = e.normal.dot(e.place - at);
        if (behind > 0) pull.force += e.normal * (k * behind);
        pull.stiffnessNmm += k;
      } else {
        const Pull well = wellPull(e.place - at, {e.rangeMm, k * e.rangeMm * kTop}, limits);
        pull.force += well.force;
        pull.stiffnessNmm += well.stiffnessNmm;
      }
    }
    pull.mostN = std::min(g.mostN, limits.forceN);
    if (const double size = pull.force.norm(); size > pull.mostN) pull.force *= pull.mostN / size;
    pull.force *= fresh;
    return pull;
  }
  template <class Hard>
  Pull operator()(const Hard&) const noexcept {
    return inRange(false);
  }
};

}  // namespace

Pull wellPull(const Vec3d& d, const WellShape& shape, const SoftLimits& limits) ARGIL_REALTIME {
  const double s2 = d.squaredNorm() / (shape.rangeMm * shape.rangeMm);
  Pull pull;
  pull.within = s2 < 1;
  pull.caught = s2 < kCatchFraction * kCatchFraction;
  // One factor for the whole well: it stays the gradient of a potential.
  pull.mostN = std::min({shape.forceN, limits.forceN, limits.stiffnessNmm * kTop * shape.rangeMm});
  pull.stiffnessNmm = pull.mostN / (kTop * shape.rangeMm);
  if (pull.within) pull.force = d * (pull.stiffnessNmm * (1 - s2) * (1 - s2));
  return pull;
}

double wellDepthNmm(const WellShape& shape, double forceN) noexcept {
  return forceN * shape.rangeMm / (6 * kTop);
}

Pull softPull(const Guide& guide, const Scene& scene, TouchableClay* clay, const Vec3d& at, const Vec3d& velocity,
              uint32_t buttons, const SoftLimits& limits, SoftMemory& memory) ARGIL_REALTIME {
  return std::visit(Puller{scene, clay, at, velocity, buttons, limits, memory}, guide.shape);
}

}  // namespace argil::haptics
