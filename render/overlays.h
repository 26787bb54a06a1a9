#pragma once
// What is drawn besides the clay.

#include <optional>
#include <vector>

#include "clay/vec.h"

namespace argil::render {

/// Colour as people name it: sRGB, 0 to 1; alpha 1 is opaque.
struct Colour {
  float r = 1, g = 1, b = 1, a = 1;
};

/// The tool: a ball on a stylus. Its shadow falls on clay and ground; a beam drops from it to where it would land, with
/// a dot and a ring there.
struct Cursor {
  Vec3d positionMm = Vec3d::Zero();    ///< Centre of the ball.
  Vec3d shaft = Vec3d(0.3, -0.25, 1);  ///< Direction from the ball to the hand, any length.
  double radiusMm = 1;
  bool contact = false;          ///< Touching: the ball glows warm instead of cool.
  Vec3d drop = -Vec3d::UnitZ();  ///< Direction of the beam, any length.
};

/// A path or guide, hidden where clay is in front of it.
struct Polyline {
  std::vector<Vec3d> pointsMm;
  Colour colour;
  float widthPixels = 2;  ///< At a picture height of 720; grows with the picture.
};

struct Overlays {
  std::optional<Cursor> cursor;
  bool grid = true;      ///< Ground at the lowest point of the clay, lines at round numbers of mm.
  bool scaleBar = true;  ///< A labelled length, true in the plane through the view's target.
  bool cavity = true;    ///< Darker hollows, lighter ridges.
  std::vector<Polyline> polylines;
};

}  // namespace argil::render
