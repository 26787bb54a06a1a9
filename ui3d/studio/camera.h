#pragma once
// The person's eye: orbit, pan, zoom, named views.

#include <array>
#include <string>

#include "render/view.h"

namespace argil::studio {

/// Moves a View about its target; z stays up in orbits. Named views and focus glide there in a fifth of a second. All positions are
/// interface units in a window of width × height. One thread.
class Camera {
 public:
  [[nodiscard]] const render::View& view() const { return view_; }
  void set(const render::View& view);

  /// A drag by (dx, dy): half of the window's height turns by 90°. `pivot`: what stays in place, usually what is under the cursor.
  void orbit(float dx, float dy, float height, const Vec3d& pivot);
  /// A drag that keeps the point at `depthMm` along the view under the cursor.
  void pan(float dx, float dy, float height, double depthMm);
  /// By a factor per click; what is under the cursor stays there. `under`: that point, world.
  void zoom(float clicks, const Vec3d& under);
  /// A 3D mouse held for `seconds`: six axes, −1 to 1 (translation right, up, towards the person; rotation about these), object mode.
  void motion(const std::array<float, 6>& axes, double seconds);

  /// One of View::names(), keeping the size of what is seen; with a box it is fitted.
  void look(const std::string& name, const render::Box& bounds, double aspect);
  void focus(const render::Box& bounds, double aspect);
  void toggleProjection();
  void openingDegrees(double degrees);

  /// Goes on with a glide. True while the view moves.
  bool tick(double seconds);

  struct Ray {
    Vec3d origin, direction;  ///< Direction of length one.
  };
  [[nodiscard]] Ray ray(float x, float y, float width, float height) const;

 private:
  render::View view_, from_, to_;
  double glide_ = 1;  // 0 to 1
};

}  // namespace argil::studio
