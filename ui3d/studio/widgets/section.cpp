// The section plane, as large as what it cuts.

#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

constexpr double kMargin = 1.15;

}  // namespace

void buildSection(Build& build) {
  const auto& section = build.world.state.look.section;
  if (!section || !(section->normal.norm() > 0)) return;
  const Vec3d n = section->normal.normalized();
  const Vec3d x = (std::abs(n.z()) < 0.9 ? n.cross(Vec3d::UnitZ()) : n.cross(Vec3d::UnitX())).normalized(),
              y = n.cross(x);
  const Vec3d middle = build.world.bounds.empty() ? section->pointMm : build.world.bounds.centre();
  const double half = 0.5 * kMargin * build.extentMm();
  const Sheet sheet{middle - (middle - section->pointMm).dot(n) * n, x, y, half, half};
  build.fill(sheet.rim(), faded(widget_colours::kSection, 0.10f));  // No tint over what is looked at.
  build.closedLine(sheet.corners(), widget_colours::kSection, 2.f);
  sheetHandles(build, sheet, {Target::Kind::section, 0}, sheet.centre, widget_colours::kSection, true);
}

}  // namespace argil::studio
