#pragma once
// From the points that a stroke went through to the stamps that it leaves.

#include <array>
#include <cstdint>
#include <vector>

#include "clay/brush/brush.h"
#include "clay/kernels/grid.h"
#include "engine/document/tool.h"
#include "engine/tools/path_point.h"

namespace argil::engine {

/// From a stamp to the next, voxels.
[[nodiscard]] double stampSpacing(const Tool& tool, const clay::Grid& grid);

/// Turns points, fed one by one, into canonical stamps: a dab at the first point, then swept segments of equal arc
/// length along a centripetal Catmull-Rom curve through all points, and the rest at the end. The stamps depend on the
/// sequence of points alone: not on time, nor on how many points came at once. A jump gives a swept path without gaps;
/// points that repeat the last one count once. The curve from one point to the next is known when the point after it is
/// there, so stamps trail the tool by one point and less than one spacing. One thread; cost of a point: the stamps that
/// it gives. Method: NOTES.md, "Stroke path".
class StrokePath {
 public:
  /// Throws Error when the tool or its quality is out of range for this grid.
  StrokePath(const clay::Grid& grid, const Tool& tool);

  /// Whether a stroke may go through this place: finite, and within 70 000 voxels of the grid's origin along each axis.
  [[nodiscard]] static bool reaches(const clay::Grid& grid, const Vec3d& pointMm);

  /// Appends to `stamps` what this point (mm) makes certain. Throws Error for a point that is not finite or out of
  /// the clay's reach; then nothing changed. Pressure and rotation change evenly from point to point.
  void add(const PathPoint& point, std::vector<clay::Stamp>& stamps);
  void add(const Vec3d& pointMm, std::vector<clay::Stamp>& stamps) { add(PathPoint{0, pointMm}, stamps); }

  /// Appends what is left up to the last point. The path is over.
  void finish(std::vector<clay::Stamp>& stamps);

  /// How many of the points given so far, counted from the first, lie on stamps that were handed out.
  [[nodiscard]] uint64_t covered() const { return covered_; }

 private:
  /// How the tool is held at a place.
  struct Held {
    double pressure = 1;
    Eigen::Quaterniond rotation = Eigen::Quaterniond::Identity();
  };
  struct Knot {
    Vec3d at = Vec3d::Zero();  // voxels
    Held held;
  };
  [[nodiscard]] static Held between(const Held& a, const Held& b, double share);
  [[nodiscard]] double radiusAt(const Held& held) const;
  void curve(const Vec3d& before, const Knot& from, const Knot& to, const Vec3d& after,
             std::vector<clay::Stamp>& stamps);
  void lineTo(const Knot& to, std::vector<clay::Stamp>& stamps);
  void stampTo(const Knot& to, std::vector<clay::Stamp>& stamps);

  clay::Grid grid_;
  Tool tool_;
  clay::Stamp stamp_;         // a: where the next stamp starts
  double spacing_;            // voxels
  std::array<Knot, 3> last_;  // the last distinct points, newest first
  int known_ = 0;             // how many of them
  uint64_t added_ = 0;        // points given, repeated ones too
  uint64_t passed_ = 0;       // of these, those that the pen has reached
  uint64_t covered_ = 0;
  Knot pen_;           // end of the curve walked so far
  double walked_ = 0;  // arc length from stamp_.a to pen_
};

}  // namespace argil::engine
