#include "haptics/contact/cutting.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace argil::haptics {
namespace {

constexpr double kPi = std::numbers::pi;
// Clay is looked for this far beyond the ball, voxels: where a cut that has arrived reads −kBeyond. Half of it is the
// threshold, so the field may err by a quarter of a voxel.
constexpr double kBeyond = 0.5;
constexpr double kHalfDiagonal = 0.87;             // Of a cell, voxels.
constexpr double kRampLow = 0.2, kRampHigh = 0.8;  // Parts of kBeyond between which a probe counts by degrees.
// Interpolation rounds the rim of a cut: what it makes the height read too low, voxels, measured over radii of 4 to 20.
constexpr double kRimRounding = 0.05;
constexpr size_t kDirections = 96;  // Probes on the half of the ball that faces the hand.
constexpr int kSubsteps = 4;
constexpr double kMaxStepVoxels = 0.5;   // Between two looks at the clay.
constexpr double kFrozenHardness = 1e4;  // Times the material's: does not yield.
constexpr double kStickMms = 1e-2;       // Speed at which touched clay bears its full load: below it nothing moves.
constexpr int kNewtonSteps = 12;
constexpr double kHistorySpacing = 0.15;  // Of the radius: how far apart remembered cuts are.

// Directions of the probes about the axis (0, 0, 1): a golden spiral, denser towards the pole, where a shallow cap is.
struct Pattern {
  std::array<double, kDirections> u, v, w, solidAngle;
  std::array<uint8_t, kDirections> zone;  // Three rings of eight.
  Pattern() {
    const double golden = kPi * (3 - std::sqrt(5.0));
    const size_t n = u.size();
    for (size_t i = 0; i < n; ++i) {
      const double t = (double(i) + 0.5) / double(n), cosine = 1 - t * t, sine = std::sqrt(1 - cosine * cosine);
      u[i] = sine * std::cos(golden * double(i));
      v[i] = sine * std::sin(golden * double(i));
      w[i] = cosine;
      solidAngle[i] = 4 * kPi * t / double(n);
      const auto eighth = static_cast<size_t>(std::floor((std::atan2(v[i], u[i]) / kPi + 1) * 4)) % 8;
      zone[i] = static_cast<uint8_t>(8 * (3 * i / n) + eighth);
    }
  }
};
const Pattern kPattern;

}  // namespace

double engagedArea(double radiusMm, double heightMm) noexcept {
  const double h = std::clamp(heightMm, 0.0, radiusMm);
  return kPi * h * (2 * radiusMm - h);
}

double restingDepth(double radiusMm, double hardnessNmm2, double forceN) noexcept {
  const double rest = radiusMm * radiusMm - forceN / (kPi * hardnessNmm2);
  return rest <= 0 ? radiusMm : radiusMm - std::sqrt(rest);
}

void CutLaw::reset() noexcept {
  first_ = count_ = 0;
  velocity_.setZero();
  patch_.count = 0;
  feel_.fill({});
}

void CutLaw::remember(const Vec3d& centre, double radiusMm, uint64_t index) ARGIL_REALTIME {
  if (count_ > 0) {
    Cut& newest = cuts_[size_t((first_ + count_ - 1) % kHistory)];
    if (newest.radius == radiusMm && (newest.centre - centre).norm() < kHistorySpacing * radiusMm) {
      newest.last = index;
      return;
    }
  }
  if (count_ == kHistory) {
    first_ = (first_ + 1) % kHistory;
    --count_;
  }
  cuts_[size_t((first_ + count_++) % kHistory)] = {centre, radiusMm, index, index};
}

void CutLaw::forget(uint64_t applied) ARGIL_REALTIME {
  while (count_ > 0 && cuts_[size_t(first_)].last < applied) {
    first_ = (first_ + 1) % kHistory;
    --count_;
  }
}

void CutLaw::measure(std::span<TouchableClay> pieces, const Scene& scene, const Vec3d& centre, double radiusMm,
                     const Vec3d& axis, bool frozen) ARGIL_REALTIME {
  patch_.count = 0;
  patch_.areaMm2 = patch_.depthMm = patch_.viscosity = patch_.drag = 0;
  loads_.fill(Vec3d::Zero());
  const Vec3d side = axis.unitOrthogonal(), other = axis.cross(side);
  for (size_t k = 0; k < pieces.size(); ++k) {
    TouchableClay& piece = pieces[k];
    clay::Sampler& sampler = piece.surface().sampler();
    const Material& material = scene.materials[scene.pieces[k].material];
    const double voxel = piece.voxelMm(), r = radiusMm / voxel, probe = r + kBeyond;
    const Vec3d at = piece.toVoxel(centre);
    if (!(at.cwiseAbs().maxCoeff() + probe < 8.0 * clay::kBrickReach)) continue;  // Out of the reach of any clay.
    const Vec3d a = piece.turnToVoxel(side) * probe, b = piece.turnToVoxel(other) * probe,
                c = piece.turnToVoxel(axis) * probe;
    // Cuts that the version does not know yet, in its voxels.
    std::array<Vec3d, kHistory> cutAt;
    std::array<double, kHistory> cutRadius;
    int cuts = 0;
    for (int i = 0; i < count_; ++i) {
      const Cut& cut = cuts_[size_t((first_ + i) % kHistory)];
      if ((cut.centre - centre).norm() > cut.radius + radiusMm + voxel) continue;
      cutAt[size_t(cuts)] = piece.toVoxel(cut.centre);
      cutRadius[size_t(cuts++)] = cut.radius / voxel;
    }
    Feel feel;
    std::array<Vec3d, kZones> zones;
    zones.fill(Vec3d::Zero());
    Vec3d sum = Vec3d::Zero();
    for (size_t i = 0; i < kPattern.u.size(); ++i) {
      const Vec3d y = at + kPattern.u[i] * a + kPattern.v[i] * b + kPattern.w[i] * c;
      // A field changes by no more than the way: far from the surface the nearest voxel says enough.
      const Coord nearest = ClosestSurface::nearestVoxel(y);
      double phi = double(sampler.voxel(nearest));
      const bool hasMaterial = piece.mixed() && phi > -double(sampler.band());
      if (phi > kHalfDiagonal) continue;
      if (phi > -kHalfDiagonal - kBeyond) phi = double(sampler.trilinear(y));
      if (phi >= -kRampLow * kBeyond) continue;
      for (int j = 0; j < cuts; ++j) phi = std::max(phi, cutRadius[size_t(j)] - (y - cutAt[size_t(j)]).norm());
      const double there = std::clamp((-phi / kBeyond - kRampLow) / (kRampHigh - kRampLow), 0.0, 1.0);
      if (there <= 0) continue;
      const double weight = there * kPattern.solidAngle[i];
      const Vec3d load = weight * (kPattern.u[i] * side + kPattern.v[i] * other + kPattern.w[i] * axis);
      if (piece.surface().hidden(nearest)) continue;
      if (hasMaterial) {
        const Material& here = scene.materials[piece.material(nearest)];
        feel.hardness += weight * here.hardnessNmm2;
        feel.viscosity += weight * here.viscosityNsmm;
        feel.drag += weight * here.dragNsmm;
        feel.weight += weight;
      }
      zones[kPattern.zone[i]] += load;
      sum += load;
    }
    // Looking beyond the ball sees a wider cap: back to the cap of the ball itself by its height (exact where the clay
    // that was cut was flat).
    const double seen = std::min(1.0, sum.norm() / kPi);  // Sine squared of the cap's half angle.
    const double height = std::clamp(r + 0.5 * kBeyond + kRimRounding - probe * std::sqrt(1 - seen), 0.0, r);
    const double area = kPi * height * (2 * r - height);
    if (seen <= 0 || area <= 0) continue;
    if (feel.weight > 0)
      feel_[k] = {feel.hardness / feel.weight, feel.viscosity / feel.weight, feel.drag / feel.weight, feel.weight};
    else if (feel_[k].weight <= 0 || !piece.mixed())
      feel_[k] = {material.hardnessNmm2, material.viscosityNsmm, material.dragNsmm, 0};
    const double load = feel_[k].hardness * (frozen ? kFrozenHardness : 1.0) * area * voxel * voxel / sum.norm();
    for (size_t i = 0; i < kZones; ++i) loads_[i] += load * zones[i];
    const double areaMm2 = area * voxel * voxel;
    patch_.areaMm2 += areaMm2;
    patch_.depthMm = std::max(patch_.depthMm, height * voxel);
    patch_.viscosity = std::max(patch_.viscosity, feel_[k].viscosity);
    patch_.drag = std::max(patch_.drag, feel_[k].drag * std::min(1.0, area / (kPi * r * r)));
  }
  for (const Vec3d& load : loads_) {
    const double size = load.norm();
    if (!(size > 0)) continue;
    const auto n = size_t(patch_.count++);
    patch_.x[n] = load.x() / size;
    patch_.y[n] = load.y() / size;
    patch_.z[n] = load.z() / size;
    patch_.load[n] = size;
  }
}

// Minimises resistance/2 · |v|² − force · v + Σ load · max(0, s · v), convex in v: clay bears its full load where the
// ball presses into it and none where it leaves. The corner at zero is rounded over kStickMms and the minimum found by
// Newton's method with a line search.
Vec3d CutLaw::yield(const Vec3d& force, double resistance, const Vec3d& guess) const ARGIL_REALTIME {
  const auto n = size_t(patch_.count);
  // Most often the ball presses on all that it touches.
  Vec3d full = Vec3d::Zero();
  for (size_t i = 0; i < n; ++i) full += patch_.load[i] * Vec3d(patch_.x[i], patch_.y[i], patch_.z[i]);
  Vec3d v = (force - full) / resistance;
  bool all = true;
  for (size_t i = 0; i < n && all; ++i) all = v.dot(Vec3d(patch_.x[i], patch_.y[i], patch_.z[i])) >= kStickMms;
  if (all) return v;

  const auto cost = [&](const Vec3d& w) {
    double sum = 0;
    for (size_t i = 0; i < n; ++i) {
      const double m = w.x() * patch_.x[i] + w.y() * patch_.y[i] + w.z() * patch_.z[i];
      const double inner = std::clamp(m, 0.0, kStickMms);
      sum += patch_.load[i] * (inner * inner / (2 * kStickMms) + std::max(0.0, m - kStickMms));
    }
    return 0.5 * resistance * w.squaredNorm() - force.dot(w) + sum;
  };
  v = guess;
  double value = cost(v);
  if (!(value < 0)) {  // Worse than standing still.
    v.setZero();
    value = 0;
  }
  for (int step = 0; step < kNewtonSteps; ++step) {
    Vec3d gradient = resistance * v - force;
    Eigen::Matrix3d hessian = Eigen::Matrix3d::Identity() * resistance;
    for (size_t i = 0; i < n; ++i) {
      const Vec3d s(patch_.x[i], patch_.y[i], patch_.z[i]);
      const double m = v.dot(s);
      if (m < 0) continue;
      const double load = patch_.load[i];
      gradient += load * std::min(1.0, m / kStickMms) * s;
      if (m < kStickMms) hessian.noalias() += (load / kStickMms) * s * s.transpose();
    }
    const Vec3d move = -hessian.inverse() * gradient;
    const double slope = gradient.dot(move);
    if (!(slope < -1e-12 * resistance)) break;
    double length = 1;
    bool better = false;
    for (int half = 0; half < 16; ++half, length *= 0.4) {
      const double next = cost(v + length * move);
      if (next <= value + 1e-4 * length * slope) {
        v += length * move;
        value = next;
        better = true;
        break;
      }
    }
    if (!better || length * move.norm() < 0.01 * kStickMms) break;
  }
  // Below the rounding of the corner it stands still.
  return v.norm() < 2 * kStickMms ? Vec3d(Vec3d::Zero()) : v;
}

CutLaw::Result CutLaw::advance(std::span<TouchableClay> pieces, const Scene& scene, const Input& input) ARGIL_REALTIME {
  Result result;
  result.centre = input.centre;
  double voxel = pieces.empty() ? 1.0 : pieces[0].voxelMm();
  for (const TouchableClay& piece : pieces) voxel = std::min(voxel, piece.voxelMm());
  const double maxStep = std::min(kMaxStepVoxels * voxel, 0.5 * input.radiusMm);
  double left = input.periodS;
  for (int step = 0; step < kSubsteps; ++step) {
    const Vec3d way = input.hand - result.centre;
    const double length = way.norm();
    if (length > 1e-3 * voxel) axis_ = way / length;
    measure(pieces, scene, result.centre, input.radiusMm, axis_, input.frozen);
    result.engaged = patch_.count > 0;
    if (!result.engaged) {
      if (length <= 1e-9) break;
      // Nothing resists: on to the hand, in steps that cannot jump over clay, and no deeper into it than a look apart.
      double go = std::min(length, std::max(maxStep, 0.5 * input.radiusMm));
      while (go > maxStep) {
        measure(pieces, scene, result.centre + axis_ * go, input.radiusMm, axis_, input.frozen);
        if (patch_.count == 0) break;
        go = std::max(maxStep, 0.5 * go);
      }
      result.centre += axis_ * go;
      if (go >= length) break;
      continue;
    }
    const double resistance = patch_.viscosity + patch_.drag + input.stiffnessNmm * left;
    velocity_ = yield(input.stiffnessNmm * way, resistance, velocity_);
    const double speed = velocity_.norm();
    const bool last = speed * left <= maxStep;
    const double time = last ? left : maxStep / speed;
    result.centre += velocity_ * time;
    left -= time;
    if (last) break;
  }
  result.depthMm = patch_.count ? patch_.depthMm : 0;
  result.areaMm2 = patch_.count ? patch_.areaMm2 : 0;
  return result;
}

}  // namespace argil::haptics
