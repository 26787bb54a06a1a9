// What the hand reaches: the device's workspace as the settings lay it into the world.

#include <fmt/format.h>

#include <algorithm>

#include "ui3d/studio/widgets/box_frame.h"
#include "ui3d/studio/widgets/build.h"

namespace argil::studio {
namespace {

constexpr double kLeastScale = 1e-6, kMostScale = 1e6;  // As Workspace::check.

/// A face takes all others along: the scale is one number. The centre stays.
void applyFace(Subject& subject, const Handle& handle, const Change& change) {
  auto* workspace = std::get_if<haptics::Workspace>(&subject);
  if (!workspace || handle.beside.empty()) return;
  const Vec3d centre = handle.beside[0];
  const double before = (handle.anchor - centre).dot(handle.axis),
               now = (handle.anchor + change.move - centre).dot(handle.axis);
  if (before > 0)
    workspace->scale = std::clamp(workspace->scale * std::max(1e-3, now / before), kLeastScale, kMostScale);
}

}  // namespace

void buildWorkspaceBox(Build& build) {
  const haptics::Workspace& workspace = build.world.state.workspace;
  BoxFrame box;
  box.pose.rotation = workspace.pose.rotation;
  box.pose.translation = workspace.toWorld(Vec3d::Zero());
  box.half = 0.5 * workspace.scale * build.world.reachMm;
  const Target target{Target::Kind::workspace, 0};
  for (const auto& edge : box.edges()) build.line({edge[0], edge[1]}, faded(widget_colours::kWorkspace, 0.8f), 1.6f);
  if (workspace.walls.on) {
    BoxFrame walls = box;
    walls.half *= workspace.walls.share;
    for (const auto& edge : walls.edges())
      build.line({edge[0], edge[1]}, faded(widget_colours::kWorkspace, 0.35f), 1.2f);
  }
  build.text(box.at(-1, -1, 1), fmt::format("reach of the hand × {:.3g}", workspace.scale), widget_colours::kWorkspace);

  Handle handle;
  handle.target = target;
  handle.colour = widget_colours::kWorkspace;
  for (int face = 0; face < 6; ++face) {
    handle.name = "face";
    handle.index = face;
    handle.way = Way::along;
    handle.anchor = box.faceCentre(face);
    handle.axis = box.normal(face);
    handle.points = {handle.anchor};
    handle.beside = {box.pose.translation};
    handle.colour =
        faded(widget_colours::kWorkspace, handle.axis.dot(build.world.screen.toEye(handle.anchor)) > 0 ? 1.f : 0.45f);
    handle.apply = applyFace;
    build.handles.push_back(handle);
  }
  handle.beside.clear();
  handle.colour = widget_colours::kWorkspace;
  handle.index = 0;
  handle.name = "centre";
  handle.way = Way::free;
  handle.form = Form::square;
  handle.anchor = box.pose.translation;
  handle.points = {handle.anchor};
  handle.apply = applyRigid;
  build.handles.push_back(handle);
  handle.name = "turn";
  handle.way = Way::about;
  handle.form = Form::path;
  handle.axis = Vec3d::UnitZ();
  // At the corner to the front right of the floor: about the vertical.
  const Vec3d out = box.at(1, -1, -1) - box.at(0, 0, -1), foot = box.at(0, 0, -1);
  const Vec3d flat = Vec3d(out.x(), out.y(), 0);
  const double radius = flat.norm();
  if (!(radius > 0)) return;
  const double half = std::min(0.6, 17 * build.unit(foot + flat) / radius);
  handle.points = arc(foot, flat / radius, Vec3d::UnitZ().cross(flat / radius), radius, -half, half, 12);
  build.handles.push_back(handle);
}

}  // namespace argil::studio
