#include <algorithm>
#include <cmath>

#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/panels/settings_tables.h"
#include "ui3d/studio/view/camera.h"

namespace argil::studio {
namespace {

constexpr engine::Parameter<render::View> kOpening{"opening",
                                                   "Opening",
                                                   "Of the picture's height: small is flat, large is near.",
                                                   "°",
                                                   5,
                                                   120,
                                                   30,
                                                   false,
                                                   [](const render::View& v) { return v.openingDegrees; },
                                                   [](render::View& v, double d) { v.openingDegrees = d; }};

void section(Context& context) {
  kit::heading("Section");
  bool on = context.state.look.section.has_value();
  if (kit::toggle("Cut open", on, "Cuts the picture, not the clay.")) runAction(context, "view.section");
  if (!context.state.look.section) return;
  render::Section& s = *context.state.look.section;
  static constexpr std::array<std::string_view, 3> kAxes{"x", "y", "z"};
  Vec3d::Index axis = 0;
  s.normal.cwiseAbs().maxCoeff(&axis);
  int chosen = std::abs(s.normal[axis]) > 0.999 * s.normal.norm() ? int(axis) : -1;
  if (kit::segmented("axis", kAxes, chosen)) s.normal = Vec3d::Unit(chosen);
  const render::Box box = context.renderer.bounds();
  const Vec3d unit = s.normal.normalized();
  double offset = s.pointMm.dot(unit);
  const double reach = box.empty() ? 100 : std::max(1.0, box.centre().cwiseAbs().maxCoeff() + 0.5 * box.size().norm());
  if (kit::number({"offset", "Place", "Along its normal.", "mm", -reach, reach, 0, false}, offset).changed)
    s.pointMm += (offset - s.pointMm.dot(unit)) * unit;
  if (kit::button("Other side", kit::Weight::plain, -1)) s.normal = -s.normal;
}

}  // namespace

void viewPanel(Context& context, Memory&) {
  const float each = std::floor((ImGui::GetContentRegionAvail().x - 2 * kGap) / 3);
  int column = 0;
  for (const char* view : {"front", "right", "top", "back", "left", "bottom"}) {
    if (column++ % 3) ImGui::SameLine();
    std::string name = view;
    name[0] = static_cast<char>(name[0] - 32);
    if (kit::button(name, kit::Weight::plain, each)) runAction(context, std::string("view.") + view);
    kit::tooltip("Look from there.", shortcutOf(*findAction(std::string("view.") + view), context.state));
  }
  bool orthographic = context.camera.view().projection == render::Projection::orthographic;
  if (kit::toggle("Orthographic", orthographic, "Parallel lines stay parallel.")) context.camera.toggleProjection();
  render::View view = context.camera.view();
  if (drawRow(kOpening, view).changed) context.camera.openingDegrees(view.openingDegrees);
  section(context);
  kit::heading("Look");
  drawRows(lookRows(), context.state.look);
  kit::heading("Two eyes");
  drawRows(stereoRows(), context.state.stereo);
}

}  // namespace argil::studio
