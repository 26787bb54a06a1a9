#pragma once
// Between the world and the window, in interface units from its top left corner.

#include <optional>
#include <span>

#include "render/view/view.h"

namespace argil::studio {

/// A line of sight; the direction's length is one.
struct Ray {
  Vec3d origin = Vec3d::Zero(), direction = -Vec3d::UnitZ();
};

/// Of one view in a window of one size. A value.
class ScreenMap {
 public:
  ScreenMap(const render::View& view, double width, double height);

  [[nodiscard]] const render::View& view() const { return view_; }
  [[nodiscard]] const render::View::Axes& axes() const { return axes_; }
  [[nodiscard]] double height() const { return height_; }

  /// x and y in interface units; z is the distance along the view in mm. Of use where seen() holds.
  [[nodiscard]] Vec3d project(const Vec3d& p) const;
  /// Before the eye.
  [[nodiscard]] bool seen(const Vec3d& p) const;
  /// How many mm an interface unit is at the depth of p.
  [[nodiscard]] double unitMm(const Vec3d& p) const;
  /// Unit direction from p to the eye.
  [[nodiscard]] Vec3d toEye(const Vec3d& p) const;
  [[nodiscard]] Ray ray(double x, double y) const;
  /// Where a ray of this view is in the window.
  [[nodiscard]] Vec3d place(const Ray& ray) const;

  /// How far in units, and where on it in the world.
  struct Near {
    double units = 0;
    double depthMm = 0;
    Vec3d point = Vec3d::Zero();
  };
  /// The place of a chain of segments that is nearest to (x, y) in the window. Nothing when all of it lies behind the
  /// eye.
  [[nodiscard]] std::optional<Near> nearest(std::span<const Vec3d> chain, double x, double y) const;
  /// Of triangles, three corners each: only inside of them. The nearest to the eye.
  [[nodiscard]] std::optional<Near> inside(std::span<const Vec3d> triangles, double x, double y) const;

 private:
  [[nodiscard]] double depth(const Vec3d& p) const { return (p - view_.position).dot(axes_.forward); }

  render::View view_;
  render::View::Axes axes_;
  double width_, height_, halfTangent_, nearMm_;
};

}  // namespace argil::studio
