#pragma once
// Where a picture is taken from.

#include <string>
#include <vector>

#include "clay/base/vec.h"

namespace argil::render {

/// An axis-aligned box in world mm. Empty until something was added.
struct Box {
  Vec3d min = Vec3d::Constant(1), max = Vec3d::Constant(-1);

  [[nodiscard]] bool empty() const { return min.x() > max.x(); }
  [[nodiscard]] Vec3d centre() const { return 0.5 * (min + max); }
  [[nodiscard]] Vec3d size() const { return max - min; }
  void add(const Vec3d& point);
  void add(const Box& other);
};

enum class Projection : uint8_t { perspective, orthographic };

/// A camera in world mm; z is up. The opening angle frames the plane through the target in both projections, so that
/// switching between them keeps the size of the model.
struct View {
  Vec3d position{0, -100, 0};
  Vec3d target = Vec3d::Zero();
  Vec3d up = Vec3d::UnitZ();  ///< Any length; replaced by another axis when it is parallel to the view.
  Projection projection = Projection::perspective;
  double openingDegrees = 30;  ///< Of the picture's height: 1 to 150.

  /// The names that named() knows: front (looking along +y), back, left, right, top, bottom, iso.
  static const std::vector<std::string>& names();
  /// A named view with `bounds` filling the picture; an empty box counts as 100 mm about zero. Throws Error for another
  /// name.
  static View named(const std::string& name, const Box& bounds, double aspect,
                    Projection projection = Projection::perspective);

  /// Moves the camera along its direction and the target to the box's centre so that the whole box is seen, with a
  /// margin of 5 % of the picture on the tightest side. `aspect` is width / height.
  void fit(const Box& bounds, double aspect);

  /// The camera carried about the upright axis (z) through the target, anticlockwise as seen from above.
  [[nodiscard]] View revolved(double degrees) const;

  /// Unit axes of the picture: to the right, up, and away from the viewer.
  struct Axes {
    Vec3d right, up, forward;
  };
  [[nodiscard]] Axes axes() const;
  [[nodiscard]] double distance() const { return (target - position).norm(); }
  /// Height in mm of what the picture shows in the plane through the target.
  [[nodiscard]] double heightAtTarget() const;
  /// Where a world point falls, in pixels from the top left corner; z is its distance along the view in mm.
  [[nodiscard]] Vec3d project(const Vec3d& point, int width, int height) const;

  /// Throws Error when a member is not finite or out of range, or when position and target coincide.
  void check() const;
};

}  // namespace argil::render
