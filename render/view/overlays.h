#pragma once
// What is drawn besides the clay.

#include <optional>
#include <vector>

#include "clay/base/vec.h"
#include "render/view/colour.h"

namespace argil::render {

/// The tool: a ball on a stylus. Its shadow falls on clay and ground; a beam drops from it to where it would land, with
/// a dot and a ring there (Look::cursorShadow, Look::beam). Its drawn stylus keeps a useful size in the picture; the
/// ball is true to scale, so it grows as it comes nearer.
struct Cursor {
  Vec3d positionMm = Vec3d::Zero();    ///< Centre of the ball.
  Vec3d shaft = Vec3d(0.3, -0.25, 1);  ///< Direction from the ball to the hand, any length.
  double radiusMm = 1;
  bool contact = false;          ///< Touching: the ball glows warm instead of cool.
  Vec3d drop = -Vec3d::UnitZ();  ///< Direction of the beam, any length.
  Vec3d forceN = Vec3d::Zero();  ///< On the hand: an arrow from the ball; none for zero.
  double fullForceN = 3;         ///< The force whose arrow is as long as the stylus.
  /// Where the tool rests on clay (the ring of its footprint is drawn there, in the plane of the normal), if it does.
  struct Footprint {
    Vec3d pointMm = Vec3d::Zero(), normal = Vec3d::UnitZ();
  };
  std::optional<Footprint> footprint;
  Colour tint{0.35f, 0.81f, 0.98f, 1};  ///< Of ball and ring while free.
  /// Of a mouse or a pen, which would only hide the work: neither ball nor stylus, the footprint's ring and a dot in
  /// it.
  bool flat = false;
};

/// How lines and faces of widgets meet the clay.
enum class Depth : uint8_t {
  hidden,  ///< Clay in front of it hides it.
  xray,    ///< Clay in front of it leaves it faint (hidden while Look::xray is off).
  onTop,   ///< Always in full.
};

/// A path, guide or edge of a widget.
struct Polyline {
  std::vector<Vec3d> pointsMm;
  Colour colour;
  float widthPixels = 2;  ///< At a picture height of 720; grows with the picture.
  Depth depth = Depth::hidden;
};

/// Faces of guides and widgets: flat, unlit, may be see-through, seen from both sides. Drawn after the clay, in order.
struct Fill {
  std::vector<Vec3d> trianglesMm;  ///< Three corners each.
  Colour colour{1, 1, 1, 0.2f};
  Depth depth = Depth::xray;
};

/// A plane as the clay shows it: a line where they meet, and a tint of the clay on the side of the normal.
struct PlaneMark {
  Vec3d pointMm = Vec3d::Zero(), normal = Vec3d::UnitZ();  ///< The normal has any length but zero.
  Colour line{1, 1, 1, 0.8f};
  Colour beyond{1, 1, 1, 0};  ///< Its alpha is how much of the clay's colour gives way to it; 0: none.
  float widthPixels = 1.5f;   ///< Of the line, at a picture height of 720; grows with the picture.
  bool dimmedToo = true;      ///< False: pieces that are dimmed (PieceLook::dimmed) show neither.
};
inline constexpr size_t kMostPlaneMarks = 4;

struct Overlays {
  std::optional<Cursor> cursor;
  std::vector<Fill> fills;
  std::vector<Polyline> polylines;
  std::vector<PlaneMark> planes;  ///< kMostPlaneMarks at most.
};

/// Throws Error (input) that names what is not finite or out of range.
void check(const Overlays& overlays);

}  // namespace argil::render
