// Centripetal Catmull-Rom: C. Yuksel, S. Schaefer, J. Keyser, "Parameterization and applications of Catmull-Rom curves",
// 2011: no cusp and no loop within a segment however unevenly the points lie. Add, multiply, divide and square root only,
// so that stamps have equal bits everywhere.

#include "engine/stroke_path.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "clay/error.h"

namespace argil::engine {
namespace {

// Points nearer than this to the last one (voxels) repeat it: a curve needs a direction, and rounding would give it one.
constexpr double kSamePoint = 1e-6;
// Lines that stand for the curve over one spacing: their corners deviate far less than the chord of a stamp does.
constexpr double kLinesPerSpacing = 4;
// Voxels from the grid's origin: beyond the largest model (65 536), and so far inside the brush's reach that no curve
// between two points swings out of it.
constexpr double kReach = 70000;
constexpr double kMinRadius = kLeastToolVoxels, kMaxRadius = kMostToolVoxels;  // the range of clay::Stamp

double length(const Vec3d& v) { return std::sqrt(v.x() * v.x() + v.y() * v.y() + v.z() * v.z()); }

}  // namespace

StrokePath::StrokePath(const clay::Grid& grid, const Tool& tool, const StrokeQuality& quality) : grid_(grid) {
  grid.check();
  stamp_.radius = tool.radiusMm / grid.voxelMm;
  stamp_.operation = tool.operation;
  stamp_.strength = tool.strength;
  if (!(stamp_.radius >= kMinRadius && stamp_.radius <= kMaxRadius)) {
    throw Error(fmt::format("a tool of radius {} mm does not fit clay of {} mm voxels; choose {} to {} mm", tool.radiusMm,
                            grid.voxelMm, kMinRadius * grid.voxelMm, kMaxRadius * grid.voxelMm));
  }
  if (!(tool.strength >= 0 && tool.strength <= 1)) {
    throw Error(fmt::format("a strength of {} is out of range; choose 0 to 1", tool.strength));
  }
  if (!(quality.spacing >= 0.01 && quality.spacing <= 1) ||
      !(quality.minSpacingVoxels >= 0.05 && quality.minSpacingVoxels <= 8)) {
    throw Error(fmt::format("a stamp spacing of {} radii and at least {} voxels is out of range; choose 0.01 to 1 and 0.05 to 8",
                            quality.spacing, quality.minSpacingVoxels));
  }
  spacing_ = std::max(quality.spacing * stamp_.radius, quality.minSpacingVoxels);
}

bool StrokePath::reaches(const clay::Grid& grid, const Vec3d& pointMm) {
  const Vec3d point = grid.toVoxel(pointMm);
  return point.allFinite() && point.cwiseAbs().maxCoeff() <= kReach;
}

void StrokePath::add(const Vec3d& pointMm, std::vector<clay::Stamp>& stamps) {
  if (!reaches(grid_, pointMm)) {
    throw Error(fmt::format("a stroke cannot go through ({}, {}, {}) mm; clay of {} mm voxels reaches {:.0f} mm from its origin",
                            pointMm.x(), pointMm.y(), pointMm.z(), grid_.voxelMm, kReach * grid_.voxelMm));
  }
  const Vec3d point = grid_.toVoxel(pointMm);
  if (known_ == 0) {
    stamp_.a = stamp_.b = pen_ = point;
    stamps.push_back(stamp_);
    passed_ = covered_ = 1;
  } else if (length(point - last_[0]) < kSamePoint) {
    ++added_;
    if (known_ == 1) passed_ = covered_ = added_;
    return;
  } else if (known_ >= 2) {
    curve(beforeLast(), last_[1], last_[0], point, stamps);
    passed_ = added_;
  }
  last_ = {point, last_[0], last_[1]};
  known_ = std::min(known_ + 1, 3);
  ++added_;
}

void StrokePath::finish(std::vector<clay::Stamp>& stamps) {
  if (known_ >= 2) {
    curve(beforeLast(), last_[1], last_[0], 2 * last_[0] - last_[1], stamps);
    if (walked_ > kSamePoint) stampTo(last_[0], stamps);
  }
  covered_ = added_;
  known_ = 0;
  walked_ = 0;
}

// The first segment has no point before it: its end, mirrored, stands there.
Vec3d StrokePath::beforeLast() const { return known_ == 3 ? last_[2] : Vec3d(2 * last_[1] - last_[0]); }

void StrokePath::curve(const Vec3d& before, const Vec3d& from, const Vec3d& to, const Vec3d& after,
                       std::vector<clay::Stamp>& stamps) {
  // Knots grow by the square root of the chord; neighbours are distinct, so no interval is zero.
  const double t0 = std::sqrt(length(from - before));
  const double t1 = std::sqrt(length(to - from));
  const double t2 = std::sqrt(length(after - to));
  const Vec3d tangentFrom = t1 * ((from - before) / t0 - (to - before) / (t0 + t1)) + (to - from);
  const Vec3d tangentTo = t1 * ((after - to) / t2 - (after - from) / (t1 + t2)) + (to - from);

  // Length of the control polygon bounds the arc length.
  const double bound = length(tangentFrom) / 3 + length(to - from + (tangentFrom + tangentTo) / -3) + length(tangentTo) / 3;
  const int lines = static_cast<int>(std::ceil(std::max(1.0, kLinesPerSpacing * bound / spacing_)));
  for (int i = 1; i < lines; ++i) {
    const double u = double(i) / lines, v = 1 - u;
    lineTo(v * v * (1 + 2 * u) * from + u * v * v * tangentFrom + u * u * (3 - 2 * u) * to - u * u * v * tangentTo, stamps);
  }
  lineTo(to, stamps);
}

void StrokePath::lineTo(const Vec3d& to, std::vector<clay::Stamp>& stamps) {
  for (double left = length(to - pen_); left > 0; left = length(to - pen_)) {
    if (walked_ + left < spacing_) {
      walked_ += left;
      pen_ = to;
      return;
    }
    // left ≥ the step > 0, so the pen moves on by it and the loop ends.
    pen_ += (to - pen_) * ((spacing_ - walked_) / left);
    stampTo(pen_, stamps);
  }
}

void StrokePath::stampTo(const Vec3d& to, std::vector<clay::Stamp>& stamps) {
  stamp_.b = to;
  stamps.push_back(stamp_);
  stamp_.a = to;
  walked_ = 0;
  covered_ = passed_;
}

}  // namespace argil::engine
