#pragma once
// A solid beside one cell as two or three flat faces that meet: an edge or a corner, convex, concave or a saddle.

#include <array>
#include <optional>

#include "clay/base/vec.h"

namespace argil::clay {

/// Coordinates are voxels from wherever the offsets are meant. All of it is a few dozen floating-point operations, in a
/// fixed order.
struct CreaseModel {
  struct Face {
    Vec3f gradient = Vec3f::Zero();  ///< Of its distance: about a unit vector, outwards.
    float offset = 0;                ///< Distance at the origin.
    Vec3f foot = Vec3f::Zero();      ///< A point on the face well away from the crease.
    [[nodiscard]] float at(const Vec3f& p) const { return gradient.dot(p) + offset; }
    /// The point of the plane nearest to p.
    [[nodiscard]] Vec3f nearest(const Vec3f& p) const { return p - (at(p) / gradient.squaredNorm()) * gradient; }
  };
  struct Line {
    Vec3f start, along;  ///< `along` is a unit vector.
  };

  std::array<Face, 3> face;
  int count = 0;  ///< 2 or 3 faces.
  bool convex[3][3] = {};

  /// Fills `convex` from the feet: two faces meet in a convex edge if each foot lies behind the other face.
  void findTurns();

  /// The field of the faces, as a maximum where they meet convexly, a minimum where concavely: exact on one side of a
  /// crease, a bound on the other.
  [[nodiscard]] float at(const Vec3f& p) const;
  /// The same where each face has this distance.
  [[nodiscard]] float joined(const std::array<float, 3>& distances) const;
  /// The distance to the surface, as far as two or three planes know, not negative.
  [[nodiscard]] float distance(const Vec3f& p) const;

  /// Where the planes of two faces meet, from the point nearest to p; nothing if they hardly turn.
  [[nodiscard]] std::optional<Line> line(int a, int b, const Vec3f& p) const;
  /// The sign that the third face's distance has where the line of a and b is an edge of the solid.
  [[nodiscard]] float sideOfThird(int a, int b) const;
  /// Where three faces meet; nothing if they meet at a shallow angle.
  [[nodiscard]] std::optional<Vec3f> corner() const;
};

}  // namespace argil::clay
