// Centripetal Catmull-Rom: C. Yuksel, S. Schaefer, J. Keyser, "Parameterization and applications of Catmull-Rom
// curves", 2011: no cusp and no loop within a segment however unevenly the points lie. Add, multiply, divide and square
// root only, so that stamps have equal bits everywhere.

#include "engine/tools/stroke_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "clay/base/error.h"

namespace argil::engine {
namespace {

// Points nearer than this to the last one (voxels) repeat it: a curve needs a direction, and rounding would give it
// one.
constexpr double kSamePoint = 1e-6;
// Lines that stand for the curve over one spacing: their corners deviate far less than the chord of a stamp does.
constexpr double kLinesPerSpacing = 4;
// Voxels from the grid's origin: beyond the largest model (65 536), and so far inside the brush's reach that no curve
// between two points swings out of it.
constexpr double kReach = 70000;
constexpr double kMinRadius = kLeastToolVoxels, kMaxRadius = kMostToolVoxels;  // the range of clay::Stamp

double pressureOf(const Tool& tool, double pressure) {
  return curvedPressure(tool.pressureCurve, pressure);
}

double length(const Vec3d& v) {
  return std::sqrt(v.x() * v.x() + v.y() * v.y() + v.z() * v.z());
}

// On a circle the tangents of the curve are too short by the sine of the turn between chords beside the turn itself:
// lengthened by this it deviates by the sixth power of the turn, not the fourth, and few points give the path of many.
// In sharp turns nothing is a circle.
double roundness(const Vec3d& before, const Vec3d& after) {
  const double cosine = before.dot(after) / (length(before) * length(after));
  return cosine > 0.5 ? 1 + 0.375 * (1 - cosine) : 1 + 0.1875 * std::max(2 * cosine, 0.0);
}

// The parabola through three points (knots by the square root of the chord) goes on beyond the last by as much as the
// last two are apart: without it a curved stroke would begin and end straight.
Vec3d beyond(const Vec3d& first, const Vec3d& middle, const Vec3d& last) {
  const double a = std::sqrt(length(middle - first)), b = std::sqrt(length(last - middle));
  // Where points crowd at one side a parabola says little: there it goes straight on.
  if (!(a > 0.5 * b && b > 0.5 * a)) return 2 * last - middle;
  const double t0 = -a, t1 = 0, t2 = b, t = 2 * b;
  return first * ((t - t1) * (t - t2) / ((t0 - t1) * (t0 - t2))) +
         middle * ((t - t0) * (t - t2) / ((t1 - t0) * (t1 - t2))) +
         last * ((t - t0) * (t - t1) / ((t2 - t0) * (t2 - t1)));
}

}  // namespace

// A hyperbola through 0 and 1, so that it needs no power.
double curvedPressure(double curve, double pressure) {
  const double late = curve >= 0 ? 1 + 4 * curve : 1 / (1 - 4 * curve);
  return pressure / (pressure + late * (1 - pressure));
}

double stampSpacing(const Tool& tool, const clay::Grid& grid) {
  return std::max(tool.quality.spacing * tool.radiusMm / grid.voxelMm, tool.quality.minSpacingVoxels);
}

StrokePath::StrokePath(const clay::Grid& grid, const Tool& tool) : grid_(grid), tool_(tool) {
  grid.check();
  const double radius = tool.radiusMm / grid.voxelMm;
  if (!(radius >= kMinRadius && radius <= kMaxRadius)) {
    throw Error(fmt::format("a tool of radius {} mm does not fit clay of {} mm voxels; choose {} to {} mm",
                            tool.radiusMm, grid.voxelMm, kMinRadius * grid.voxelMm, kMaxRadius * grid.voxelMm));
  }
  if (!(tool.strength >= 0 && tool.strength <= 1)) {
    throw Error(fmt::format("a strength of {} is out of range; choose 0 to 1", tool.strength));
  }
  tool.quality.check();
  spacing_ = stampSpacing(tool, grid);
}

bool StrokePath::reaches(const clay::Grid& grid, const Vec3d& pointMm) {
  const Vec3d point = grid.toVoxel(pointMm);
  return point.allFinite() && point.cwiseAbs().maxCoeff() <= kReach;
}

void StrokePath::add(const PathPoint& given, std::vector<clay::Stamp>& stamps) {
  if (!reaches(grid_, given.mm)) {
    throw Error(fmt::format(
        "a stroke cannot go through ({}, {}, {}) mm; clay of {} mm voxels reaches {:.0f} mm from its origin",
        given.mm.x(), given.mm.y(), given.mm.z(), grid_.voxelMm, kReach * grid_.voxelMm));
  }
  if (!(given.pressure >= 0 && given.pressure <= 1))
    throw Error(fmt::format("a pressure of {} is out of range; give 0 to 1", given.pressure));
  Knot point{grid_.toVoxel(given.mm), {given.pressure, given.rotation.value_or(Eigen::Quaterniond::Identity())}};
  if (!point.held.rotation.coeffs().allFinite() || !(point.held.rotation.norm() > 1e-6))
    throw Error("a stylus is held at a rotation that is none");
  point.held.rotation.normalize();
  if (known_ == 0) {
    pen_ = point;
    stamp_.a = point.at;
    stampTo(point, stamps);
    passed_ = covered_ = 1;
  } else if (length(point.at - last_[0].at) < kSamePoint) {
    ++added_;
    if (known_ == 1) passed_ = covered_ = added_;
    return;
  } else if (known_ == 2) {
    curve(beyond(point.at, last_[0].at, last_[1].at), last_[1], last_[0], point.at, stamps);
    passed_ = added_;
  } else if (known_ == 3) {
    curve(last_[2].at, last_[1], last_[0], point.at, stamps);
    passed_ = added_;
  }
  last_ = {point, last_[0], last_[1]};
  known_ = std::min(known_ + 1, 3);
  ++added_;
}

void StrokePath::finish(std::vector<clay::Stamp>& stamps) {
  if (known_ == 2) curve(2 * last_[1].at - last_[0].at, last_[1], last_[0], 2 * last_[0].at - last_[1].at, stamps);
  if (known_ == 3) curve(last_[2].at, last_[1], last_[0], beyond(last_[2].at, last_[1].at, last_[0].at), stamps);
  if (known_ >= 2 && walked_ > kSamePoint) stampTo(last_[0], stamps);
  covered_ = added_;
  known_ = 0;
  walked_ = 0;
}

StrokePath::Held StrokePath::between(const Held& a, const Held& b, double share) {
  // Between neighbouring points the shorter way, without trigonometry.
  const double side = a.rotation.dot(b.rotation) < 0 ? -1 : 1;
  Eigen::Quaterniond rotation(a.rotation.coeffs() + share * (side * b.rotation.coeffs() - a.rotation.coeffs()));
  if (!(rotation.norm() > 1e-6)) rotation = b.rotation;
  rotation.normalize();
  return {a.pressure + share * (b.pressure - a.pressure), rotation};
}

double StrokePath::radiusAt(const Held& held) const {
  const double share = 1 - tool_.radiusByPressure * (1 - pressureOf(tool_, held.pressure));
  return std::max(tool_.radiusMm / grid_.voxelMm * share, kMinRadius);
}

void StrokePath::curve(const Vec3d& before, const Knot& start, const Knot& end, const Vec3d& after,
                       std::vector<clay::Stamp>& stamps) {
  const Vec3d &from = start.at, &to = end.at;
  // Knots grow by the square root of the chord; neighbours are distinct, so no interval is zero.
  const double t0 = std::sqrt(length(from - before));
  const double t1 = std::sqrt(length(to - from));
  const double t2 = std::sqrt(length(after - to));
  const Vec3d tangentFrom =
      roundness(from - before, to - from) * (t1 * ((from - before) / t0 - (to - before) / (t0 + t1)) + (to - from));
  const Vec3d tangentTo =
      roundness(to - from, after - to) * (t1 * ((after - to) / t2 - (after - from) / (t1 + t2)) + (to - from));

  // Length of the control polygon bounds the arc length.
  const double bound =
      length(tangentFrom) / 3 + length(to - from + (tangentFrom + tangentTo) / -3) + length(tangentTo) / 3;
  const int lines = static_cast<int>(std::ceil(std::max(1.0, kLinesPerSpacing * bound / spacing_)));
  for (int i = 1; i < lines; ++i) {
    const double u = double(i) / lines, v = 1 - u;
    lineTo({v * v * (1 + 2 * u) * from + u * v * v * tangentFrom + u * u * (3 - 2 * u) * to - u * u * v * tangentTo,
            between(start.held, end.held, u)},
           stamps);
  }
  lineTo(end, stamps);
}

void StrokePath::lineTo(const Knot& to, std::vector<clay::Stamp>& stamps) {
  for (double left = length(to.at - pen_.at); left > 0; left = length(to.at - pen_.at)) {
    if (walked_ + left < spacing_) {
      walked_ += left;
      pen_ = to;
      return;
    }
    // left ≥ the step > 0, so the pen moves on by it and the loop ends.
    const double share = (spacing_ - walked_) / left;
    pen_ = {pen_.at + (to.at - pen_.at) * share, between(pen_.held, to.held, share)};
    stampTo(pen_, stamps);
  }
}

void StrokePath::stampTo(const Knot& to, std::vector<clay::Stamp>& stamps) {
  const bool first = known_ == 0;
  const double radius = radiusAt(to.held);
  stamp_.b = to.at;
  stamp_.radius = first ? radius : stamp_.endRadius;
  stamp_.endRadius = radius;
  stamp_.strength =
      static_cast<float>(tool_.strength * (1 - tool_.strengthByPressure * (1 - pressureOf(tool_, to.held.pressure))));
  stamp_.axes = to.held.rotation.toRotationMatrix().cast<float>();
  stamps.push_back(stamp_);
  stamp_.a = to.at;
  walked_ = 0;
  covered_ = passed_;
}

}  // namespace argil::engine
