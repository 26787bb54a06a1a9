// The planes of symmetry. Their arrows stand at the rim: the clay in the middle is for sculpting.

#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

constexpr double kMargin = 1.1;

}  // namespace

void buildSymmetry(Build& build) {
  const engine::Symmetry& symmetry = build.document.symmetry;
  const bool on[3] = {symmetry.x, symmetry.y, symmetry.z};
  const Eigen::Matrix3d axes = symmetry.pose.rotation.toRotationMatrix();
  const double half = 0.5 * kMargin * build.extentMm();
  for (int i = 0; i < 3; ++i) {
    if (!on[i]) continue;
    // Centred on the model, so that it is seen whole wherever the pose is in it.
    const Vec3d middle = build.world.bounds.empty() ? symmetry.pose.translation : build.world.bounds.centre();
    const Vec3d n = axes.col(i);
    const Vec3d centre = middle - (middle - symmetry.pose.translation).dot(n) * n;
    const Sheet sheet{centre, axes.col((i + 1) % 3), axes.col((i + 2) % 3), half, half};
    build.fill(sheet.triangles(), faded(axisColour(i), 0.05f));
    build.closedLine(sheet.corners(), faded(axisColour(i), 0.8f), 1.6f);
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
