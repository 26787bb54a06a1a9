#include "haptics/devices/falcon_kinematics.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <vector>

namespace argil::haptics {
namespace {

constexpr FalconGeometry kG;
constexpr double kRad = std::numbers::pi / 180;
constexpr double kHinges = 2 * kG.hinge, kHingesSquare = kHinges * kHinges;
// A leg's joint on the grip and its arm's axis on the base differ by a constant, so the grip can be shrunk to a point.
constexpr double kAxisU = kG.baseU - kG.gripU, kAxisV = kG.baseV - kG.gripV;
// How far the rods lean sideways, for the first guess: (kLean[0] + kLean[1] · sum of the arms' angles) × the difference
// of the other two arms' angles, mm. Least squares over the ball of 100 mm about the centre, 1.8 mm rms; the guess of
// the place is then 0.15 mm off.
constexpr std::array<double, 2> kLean = {36.1, 10.5};
constexpr double kStepDoneMm = 0.3;  // Newton squares the error: less than 0.003 mm is left after such a step.
constexpr int kMostSteps = 8;        // One or two within the workspace, more where the linkage is nearly stretched.
constexpr int kMostCounts = 4096;    // 149° either way: no arm turns that far.

struct Leg {
  double cosine, sine;
};
// Of kFalconLegDeg: written out, since no cosine is constexpr, and checked by the round trip against the inverse.
constexpr double kCos15 = 0.96592582628906829, kSin15 = 0.25881904510252076, kCos45 = 0.70710678118654752;
constexpr std::array<Leg, 3> kLegs = {{{-kSin15, kCos15}, {kCos15, -kSin15}, {-kCos45, -kCos45}}};

/// From a leg's frame (u along the leg, v sideways, w = z) to the base's.
Vec3d fromLeg(const Leg& leg, double u, double v, double w) {
  return {leg.cosine * u - leg.sine * v, leg.sine * u + leg.cosine * v, w};
}

struct Arms {
  std::array<double, 3> angle, cosine, sine;
};

/// The spheres around the three knees meet in two points: the one farther from the base. The hinges make each leg's
/// surface a torus; with the rods' lean guessed it is a sphere.
bool meet(const Arms& arms, const std::array<Vec3d, 3>& knees, Vec3d& p) {
  std::array<double, 3> square;
  const double perDifference = kLean[0] + kLean[1] * (arms.angle[0] + arms.angle[1] + arms.angle[2]);
  for (size_t i = 0; i < 3; ++i) {
    const double lean = (perDifference * (arms.angle[(i + 1) % 3] - arms.angle[(i + 2) % 3]) - kAxisV) / kG.rod;
    const double leanSquare = std::min(lean * lean, 0.5);
    // √(1 − x) by its series: near enough for a guess.
    square[i] = kHingesSquare + kG.rod * kG.rod + 2 * kHinges * kG.rod * (1 - leanSquare * (0.5 + 0.125 * leanSquare));
  }
  // The centre of the circle of places as far from each knee as its sphere says, then up along the normal of the knees'
  // plane.
  const Vec3d a = knees[1] - knees[0], b = knees[2] - knees[0];
  const Vec3d normal = a.cross(b);
  const double normalSquare = normal.squaredNorm();
  if (!(normalSquare > 1)) return false;
  const double perNormal = 1 / normalSquare;
  const Vec3d across =
      ((a.squaredNorm() + square[0] - square[1]) * b - (b.squaredNorm() + square[0] - square[2]) * a).cross(normal) *
      (0.5 * perNormal);
  const double heightSquare = (square[0] - across.squaredNorm()) * perNormal;
  if (!(heightSquare > 0)) return false;
  p = knees[0] + across + normal * std::copysign(std::sqrt(heightSquare), normal.z());
  return true;
}

bool solve(const Arms& arms, FalconPose& pose) {
  std::array<Vec3d, 3> knees, turns;  // turns: d(knee)/dθ.
  for (size_t i = 0; i < 3; ++i) {
    const double u = kG.arm * arms.cosine[i], w = kG.arm * arms.sine[i];
    knees[i] = fromLeg(kLegs[i], kAxisU + u, kAxisV, w);
    turns[i] = fromLeg(kLegs[i], -w, 0, u);
  }
  Vec3d p;
  if (!meet(arms, knees, p)) return false;

  // A leg closes where x, from its knee to the grip, lies on the torus of radii hinges and rod about the knee's
  // sideways axis t: S² = 4 hinges² (|x|² − (t·x)²) with S = |x|² + hinges² − rod². Without roots, so a step costs one
  // division. Its gradient is along the rods.
  std::array<Vec3d, 3> rods, crosses;
  double perDeterminant = 0;
  for (int step = 0;; ++step) {
    std::array<double, 3> miss;
    for (size_t i = 0; i < 3; ++i) {
      const Leg& leg = kLegs[i];
      const Vec3d x = p - knees[i];
      const double sideways = leg.cosine * x.y() - leg.sine * x.x();
      const double square = x.squaredNorm();
      const double s = square + (kHingesSquare - kG.rod * kG.rod);
      miss[i] = 0.25 * s * s - kHingesSquare * (square - sideways * sideways);
      const double along = 2 * kHingesSquare * sideways;
      rods[i] = (s - 2 * kHingesSquare) * x + Vec3d(-leg.sine * along, leg.cosine * along, 0);
    }
    crosses = {rods[1].cross(rods[2]), rods[2].cross(rods[0]), rods[0].cross(rods[1])};
    perDeterminant = 1 / rods[0].dot(crosses[0]);
    const Vec3d move = (miss[0] * crosses[0] + miss[1] * crosses[1] + miss[2] * crosses[2]) * perDeterminant;
    p -= move;
    if (move.squaredNorm() < kStepDoneMm * kStepDoneMm) break;
    if (step == kMostSteps) return false;
  }
  // The rods are those of the place before the last step: near enough for a Jacobian.
  pose.positionMm = {p.x(), p.y(), p.z() - kFalconCentreMm};
  for (size_t i = 0; i < 3; ++i)
    pose.jacobian.col(Eigen::Index(i)) = crosses[i] * (rods[i].dot(turns[i]) * perDeterminant);
  return true;
}

double armAngle(int count) {
  return (kFalconHomeDeg + kFalconDegPerCount * count) * kRad;
}

/// Of every count that an arm can have: three lines of cache a tick instead of three sines and cosines.
struct Turn {
  double cosine, sine;
};
const std::vector<Turn> kTurns = [] {
  std::vector<Turn> turns;
  for (int count = -kMostCounts; count <= kMostCounts; ++count)
    turns.push_back({std::cos(armAngle(count)), std::sin(armAngle(count))});
  return turns;
}();

}  // namespace

Vec3d falconArmAngles(const FalconCounts& counts) ARGIL_REALTIME {
  return {armAngle(counts[0]), armAngle(counts[1]), armAngle(counts[2])};
}

bool falconPose(const FalconCounts& counts, FalconPose& pose) ARGIL_REALTIME {
  Arms arms;
  for (size_t i = 0; i < 3; ++i) {
    if (counts[i] < -kMostCounts || counts[i] > kMostCounts) return false;
    const Turn& turn = kTurns[static_cast<size_t>(counts[i] + kMostCounts)];
    arms.angle[i] = armAngle(counts[i]);
    arms.cosine[i] = turn.cosine;
    arms.sine[i] = turn.sine;
  }
  return solve(arms, pose);
}

bool falconPose(const Vec3d& anglesRad, FalconPose& pose) ARGIL_REALTIME {
  Arms arms;
  for (size_t i = 0; i < 3; ++i) {
    arms.angle[i] = anglesRad[Eigen::Index(i)];
    arms.cosine[i] = std::cos(arms.angle[i]);
    arms.sine[i] = std::sin(arms.angle[i]);
  }
  return solve(arms, pose);
}

bool falconInverse(const Vec3d& positionMm, Vec3d& anglesRad) ARGIL_REALTIME {
  Vec3d angles;
  for (size_t i = 0; i < 3; ++i) {
    const Leg& leg = kLegs[i];
    const double u = leg.cosine * positionMm.x() + leg.sine * positionMm.y() - kAxisU;
    const double v = leg.cosine * positionMm.y() - leg.sine * positionMm.x() - kAxisV;
    const double w = positionMm.z() + kFalconCentreMm;
    const double tilt = kG.rod * kG.rod - v * v;
    if (!(tilt > 0)) return false;
    const double reach = kHinges + std::sqrt(tilt);
    const double far = std::hypot(u, w);
    const double cosine = (far * far + kG.arm * kG.arm - reach * reach) / (2 * kG.arm * far);
    if (!(std::abs(cosine) < 1)) return false;
    angles[Eigen::Index(i)] = std::atan2(w, u) - std::acos(cosine);  // The knees point outwards.
  }
  anglesRad = angles;
  return true;
}

Vec3d falconForce(const FalconPose& pose, const Vec3d& torquesNmm) {
  return pose.jacobian.transpose().partialPivLu().solve(torquesNmm);
}

}  // namespace argil::haptics
