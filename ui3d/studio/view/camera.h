#pragma once
// The person's eye: orbit, pan, zoom, named views.

#include <array>
#include <string>

#include "render/view/view.h"

namespace argil::studio {

/// Moves a View about its target; z stays up in orbits. Named views and focus glide there in a fifth of a second; what
/// the hand does ends a glide. The view's `up` is always its true upward axis, so the poles need no care. What the
/// picture shows in the plane of the target stays between 1 µm and 10 km high: beyond, a zoom stops. All positions are
/// interface units in a window of width × height. One thread.
class Camera {
 public:
  static constexpr double kLeastHeightMm = 1e-3, kMostHeightMm = 1e7;

  Camera();
  [[nodiscard]] const render::View& view() const { return view_; }
  /// Throws Error for a view that View::check() refuses.
  void set(const render::View& view);

  /// A drag by (dx, dy): half of the window's height turns by 90°. `pivot`: what stays in place, usually what is under
  /// the cursor. Stops at the poles. A view that leans (a 3D mouse does that) comes upright little by little.
  void orbit(float dx, float dy, float height, const Vec3d& pivot);
  /// A drag that keeps the point at `depthMm` along the view under the cursor.
  void pan(float dx, float dy, float height, double depthMm);
  /// By a factor per click; what is under the cursor stays there. `under`: that point, world.
  void zoom(float clicks, const Vec3d& under);
  /// A 3D mouse held for `seconds`: six axes, −1 to 1 (translation right, up, towards the person; rotation about
  /// these), object mode: the model goes where the cap goes, and turns about the target.
  void motion(const std::array<float, 6>& axes, double seconds);

  /// Turns to one of View::names() about `pivot`, which keeps its place in the picture and its size. Throws Error for
  /// another name.
  void look(const std::string& name, const Vec3d& pivot);
  /// All of the box, from where we look now; an empty one counts as 100 mm about zero.
  void focus(const render::Box& bounds, double aspect);
  /// Keeps the size of what lies in the plane of the target; so does openingDegrees, 1 to 150.
  void toggleProjection();
  void openingDegrees(double degrees);

  /// Goes on with a glide. True while the view moves.
  bool tick(double seconds);

  struct Ray {
    Vec3d origin, direction;  ///< Direction of length one.
  };
  /// The line of sight through a place in the window. Orthographic ones begin far behind the camera, as everything
  /// there is seen.
  [[nodiscard]] Ray ray(float x, float y, float width, float height) const;

 private:
  void glideTo(const render::View& view);

  render::View view_, from_, to_;
  double glide_ = 1;  // 0 to 1
};

}  // namespace argil::studio
