// The planes of symmetry, thin lines on the clay, and the circle of strokes that are repeated around an axis. Their
// arrows stand beside the model: the clay in the middle is for sculpting.

#include <cmath>
#include <numbers>

#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

constexpr double kMargin = 1.1;
constexpr double kTick = 0.12;  // Of the circle's radius.

// The axis and a circle around the model, with a mark for each image.
void buildTurns(Build& build, const engine::Symmetry& symmetry, double radius) {
  const Eigen::Matrix3d axes = symmetry.pose.rotation.toRotationMatrix();
  const Vec3d centre = symmetry.pose.translation, axis = axes.col(2);
  const render::Colour colour = faded(axisColour(2), 0.8f);
  build.line({centre - radius * axis, centre + radius * axis}, colour, 1.6f);
  build.closedLine(arc(centre, axes.col(0), axes.col(1), radius, 0, 2 * std::numbers::pi, 72), faded(colour, 0.4f),
                   1.2f);
  for (int i = 0; i < symmetry.turns; ++i) {
    const double angle = 2 * std::numbers::pi * i / symmetry.turns;
    const Vec3d out = std::cos(angle) * axes.col(0) + std::sin(angle) * axes.col(1);
    build.line({centre + (1 - kTick) * radius * out, centre + (1 + kTick) * radius * out}, colour, 2.4f);
  }
}

}  // namespace

void buildSymmetry(Build& build) {
  const engine::Symmetry& symmetry = build.document.symmetry;
  const bool on[3] = {symmetry.x, symmetry.y, symmetry.z};
  const Eigen::Matrix3d axes = symmetry.pose.rotation.toRotationMatrix();
  const double half = 0.5 * kMargin * build.extentMm();
  if (symmetry.turns > 1) buildTurns(build, symmetry, half);
  for (int i = 0; i < 3; ++i) {
    if (!on[i]) continue;
    // Centred on the model, so that it is seen whole wherever the pose is in it.
    const Vec3d middle = build.world.bounds.empty() ? symmetry.pose.translation : build.world.bounds.centre();
    const Vec3d n = axes.col(i);
    const Vec3d centre = middle - (middle - symmetry.pose.translation).dot(n) * n;
    const Sheet sheet{centre, axes.col((i + 1) % 3), axes.col((i + 2) % 3), half, half};
    render::PlaneMark mark;
    mark.pointMm = centre;
    mark.normal = n;
    mark.line = faded(axisColour(i), 0.85f);
    mark.dimmedToo = false;  // Strokes go onto the piece that is worked on alone.
    build.planes.push_back(mark);
    // The rim that is highest, of a level plane that to the right.
    const Vec3d foot = i == 2 ? sheet.at(1, 0) : i == 0 ? sheet.at(0, 1) : sheet.at(1, 0);
    sheetHandles(build, sheet, {Target::Kind::symmetry, 0}, foot, axisColour(i), false);
    build.handles.back().index = i;
    build.handles.back().anchor = symmetry.pose.translation;
    // A quarter along another rim: turns the planes about that rim's direction.
    Handle tilt = build.handles.back();
    tilt.name = "tilt";
    tilt.way = Way::about;
    const Vec3d out = i == 2 ? sheet.y : i == 0 ? sheet.x : sheet.y;
    tilt.axis = out.cross(sheet.normal());
    tilt.form = Form::path;
    tilt.aligns = false;
    const Vec3d rim = sheet.centre + half * out;
    const double length = std::min(0.6, 17 * build.unit(rim) / half);
    tilt.anchor = symmetry.pose.translation;
    tilt.points = arc(sheet.centre, out, sheet.normal(), half, -length, length, 12);
    if (std::abs(build.world.screen.toEye(rim).dot(tilt.axis)) > 0.12) build.handles.push_back(tilt);
  }
}

}  // namespace argil::studio
