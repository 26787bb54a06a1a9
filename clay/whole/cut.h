#pragma once
// Clay cut along a surface: a plane, or a drawn curve that is swept along a direction.

#include <memory>
#include <span>
#include <vector>

#include "clay/base/job.h"
#include "clay/kernels/brick.h"
#include "clay/store/version.h"

namespace argil::clay {

struct ThinParts;  // clay/field/thin_parts.h

/// Divides space by an exact signed distance, in mm of the piece. Uses add, multiply, divide, square root, min and max
/// alone. Const members: any number of threads.
class Divider {
 public:
  virtual ~Divider() = default;
  /// Negative on the first side.
  [[nodiscard]] virtual double distance(const Vec3d& mm) const = 0;
  /// Distances at 8×8×8 places, `step` mm apart from `first` on, in the order of a brick.
  virtual void distances(const Vec3d& first, double step, std::span<double, kBrickVoxels> out) const;
};

/// The first side is what the normal points away from.
class PlaneDivider : public Divider {
 public:
  /// Throws Error for numbers that are not finite or no normal.
  PlaneDivider(const Vec3d& pointMm, const Vec3d& normal);
  [[nodiscard]] double distance(const Vec3d& mm) const override { return (mm - point_).dot(normal_); }

 private:
  Vec3d point_, normal_;
};

/// A wire: a curve swept along a direction, both ways without end. Of a closed curve the inside is the first side; of
/// an open one, which goes straight on at its ends, what lies to the left of it as it is drawn, seen along the
/// direction (so above a line that is drawn from left to right). Where it crosses itself, sides alternate.
class CurveDivider : public Divider {
 public:
  struct Curve {
    std::vector<Vec3d> pointsMm;  ///< 2 to 4096, closed 3 and more; their place along the direction does not matter.
    Vec3d direction = -Vec3d::UnitZ();  ///< The direction of sight.
    bool closed = false;
    /// Above 0: points closer than this are left out, and a smooth curve leads through the others, in chords of about
    /// this length; corners of more than 60° stay.
    double smoothMm = 0;
  };
  /// Throws Error for what is out of range, not finite, or no curve.
  explicit CurveDivider(const Curve& curve);
  [[nodiscard]] double distance(const Vec3d& mm) const override;
  /// Looks at the near part of the curve alone.
  void distances(const Vec3d& first, double step, std::span<double, kBrickVoxels> out) const override;

 private:
  using Vec2d = Eigen::Vector2d;
  struct Edge {
    Vec2d from, to;
    bool endless = false;  ///< Goes on behind `to`.
  };
  [[nodiscard]] Vec2d flat(const Vec3d& mm) const { return {mm.dot(right_), mm.dot(up_)}; }
  [[nodiscard]] static double squared(const Edge& edge, const Vec2d& p);
  [[nodiscard]] bool first(const Vec2d& p) const;

  Vec3d right_, up_;
  std::vector<Edge> edges_;  // what distances are taken to
  // a closed polygon for the sides: the curve, and of an open one a way around far outside
  std::vector<Edge> outline_;
  std::vector<double> levels_;                   // heights of its corners, rising
  std::vector<std::vector<uint32_t>> crossing_;  // its edges between a level and the next
};

/// The clay on one side of a divider, closed by sharp edges there, with distances again beside them. In the version's
/// own store the result shares what the cut does not come near, whole nodes at once; another one (for a second piece,
/// or beside somebody who edits) gets a copy. Clay far from the cut keeps its bits. Nothing of it may be left. Throws
/// Cancelled. Films thinner than kThinnest, where the cut runs along the surface, go and are added to `gone`. The
/// result does not depend on `threads` (0: all cores). Cost follows the cut surface, and in another store the model.
[[nodiscard]] Version cut(const Version& version, const Divider& divider, bool keepFirst, std::shared_ptr<Store> store,
                          Job* job = nullptr, int threads = 0, ThinParts* gone = nullptr);

}  // namespace argil::clay
