#include "ui3d/studio/panels/view_actions.h"

#include <algorithm>
#include <array>

#include "ui3d/studio/kit/rows.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/panels/settings_tables.h"
#include "ui3d/studio/view/camera.h"

namespace argil::studio {
namespace {

using Text = std::string_view;

double aspect(const Context& c) {
  return freeAspect(layoutOf(c).free, c.width, c.height);
}
constexpr int kSightsAcross = 9;      // Rays that look for what is seen.
constexpr double kMarginOfAll = 0.1;  // Share of the free part by which a thing seen whole may leave it.

// The middle of what the picture shows beside the panels: of everything, where all of it is there, else of the surface
// that is seen; the view's target where that is none.
Vec3d middleOfSeen(const Context& c) {
  const render::View& view = c.camera.view();
  const kit::Rect free = layoutOf(c).free;
  const render::Box box = c.renderer.bounds();
  if (box.empty()) return view.target;
  // The box is larger than what is in it, and its near corners stand out most: they are taken at the depth of its
  // middle, and may leave the free part by a tenth of it.
  const Vec3d forward = view.axes().forward, centre = box.centre();
  const double margin = kMarginOfAll * std::min(free.width(), free.height());
  const auto within = [&](const Vec3d& corner) {
    const Vec3d flat = corner - forward.dot(corner - centre) * forward;
    const Vec3d at = view.project(flat, int(c.width), int(c.height));
    return at.z() > 0 && at.x() >= double(free.left) - margin && at.x() <= double(free.right) + margin &&
           at.y() >= double(free.top) - margin && at.y() <= double(free.bottom) + margin;
  };
  bool all = true;
  for (int i = 0; i < 8; ++i)
    all = all &&
          within({(i & 1 ? box.max : box.min).x(), (i & 2 ? box.max : box.min).y(), (i & 4 ? box.max : box.min).z()});
  if (all) return centre;
  render::Box seen;
  for (int i = 0; i < kSightsAcross * kSightsAcross; ++i) {
    const float across = (float(i % kSightsAcross) + 0.5f) / kSightsAcross,
                down = (float(i / kSightsAcross) + 0.5f) / kSightsAcross;
    const Camera::Ray ray =
        c.camera.ray(free.left + across * free.width(), free.top + down * free.height(), c.width, c.height);
    if (const auto hit = c.renderer.pick(ray.origin, ray.direction, c.state.look.section))
      seen.add(Vec3d(ray.origin + hit->distanceMm * ray.direction));
  }
  return seen.empty() ? view.target : seen.centre();
}
void look(Context& c, Text view) {
  c.camera.look(std::string(view), middleOfSeen(c));
}
void focusAll(Context& c, Text) {
  c.camera.focus(c.renderer.bounds(), aspect(c));
}
void focusSelected(Context& c, Text) {
  render::Box box;
  std::vector<engine::Id> ids = c.state.selection();
  if (ids.empty()) ids.push_back(c.now.document->active);
  for (const engine::Id id : ids) {
    if (const engine::Guide* guide = c.now.document->guide(id)) {
      for (const Vec3d& point : guide->pointsMm) box.add(point);
      if (guide->pointsMm.empty()) {
        const double reach = 0.5 * std::max(1.0, guide->sizeMm.norm());
        box.add(guide->pose.translation - Vec3d::Constant(reach));
        box.add(guide->pose.translation + Vec3d::Constant(reach));
      }
    } else if (c.now.document->thing(id)) {
      box.add(c.renderer.bounds(id));
    }
  }
  c.camera.focus(box.empty() ? c.renderer.bounds() : box, aspect(c));
}
constexpr float kZoomClicks = 3;  // Of the wheel, for each press of a key.
void zoom(Context& c, float clicks) {
  c.camera.zoom(clicks, c.camera.view().target);
}
void switchProjection(Context& c, Text) {
  c.camera.toggleProjection();
}
bool isOrthographic(const Context& c, Text) {
  return c.camera.view().projection == render::Projection::orthographic;
}
void switchSection(Context& c, Text) {
  if (c.state.look.section) {
    c.state.section = c.state.look.section;
    c.state.look.section.reset();
    return;
  }
  if (!c.state.section) {  // The first time: the front half away, as the front view sees it.
    const render::Box box = c.renderer.bounds();
    c.state.section = render::Section{box.empty() ? Vec3d(Vec3d::Zero()) : box.centre(), -Vec3d::UnitY()};
  }
  c.state.look.section = c.state.section;
}
bool hasSection(const Context& c, Text) {
  return c.state.look.section.has_value();
}

bool render::Look::*lookOf(Text id) {
  for (const auto& row : lookRows())
    if (const auto* look = std::get_if<Switch<render::Look>>(&row); look && look->id == id) return look->on;
  return nullptr;
}
void switchLook(Context& c, Text id) {
  if (const auto member = lookOf(id)) c.state.look.*member = !(c.state.look.*member);
  if (id == "xray" && c.now.document->guides.empty() && !c.state.look.section)
    c.bench.tell(engine::Message::Level::done,
                 std::string("X-ray of guides is ") + (c.state.look.xray ? "on" : "off") +
                     ". There is no guide yet: add one from the Guides menu to see it through the clay.");
}
bool isLook(const Context& c, Text id) {
  const auto member = lookOf(id);
  return member && c.state.look.*member;
}

/// One of a few values by its name.
template <class Value>
struct Named {
  Text id, name, help;
  Value value;
};
template <class Value, size_t n>
void choose(const std::array<Named<Value>, n>& rows, Text id, Value& into) {
  for (const auto& row : rows)
    if (row.id == id) into = row.value;
}
template <class Value, size_t n>
bool isChosen(const std::array<Named<Value>, n>& rows, Text id, Value now) {
  return std::any_of(rows.begin(), rows.end(), [&](const auto& row) { return row.id == id && row.value == now; });
}

using NamedShading = Named<render::Shading>;
constexpr std::array kShadings{
    NamedShading{"matcap", "Shade as a material ball", "Form at a glance, without lights.", render::Shading::matcap},
    NamedShading{"lit", "Shade by lights", "Key, fill and dome light on each piece's colour.", render::Shading::lit},
    NamedShading{"material", "Shade as a material", "Lit, with roughness and gloss.", render::Shading::material},
};
using NamedStereo = Named<render::StereoMode>;
constexpr std::array kStereo{
    NamedStereo{"mono", "Stereo off", "One picture for both eyes.", render::StereoMode::mono},
    NamedStereo{"anaglyph", "Stereo: red and cyan", "For red and cyan glasses.", render::StereoMode::anaglyph},
    NamedStereo{"sideBySide", "Stereo: side by side", "Left eye in the left half.", render::StereoMode::sideBySide},
    NamedStereo{"topBottom", "Stereo: top and bottom", "Left eye in the upper half.", render::StereoMode::topBottom},
    NamedStereo{"leftEye", "Stereo: left eye alone", "For pairs of pictures.", render::StereoMode::leftEye},
    NamedStereo{"rightEye", "Stereo: right eye alone", "For pairs of pictures.", render::StereoMode::rightEye},
};

}  // namespace

void addViewRows(std::vector<Action>& rows) {
  struct Row {
    const char *view, *name, *key;
  };
  for (const Row& row :
       {Row{"front", "Front view", "1"}, Row{"back", "Back view", "Ctrl+1"}, Row{"right", "Right view", "3"},
        Row{"left", "Left view", "Ctrl+3"}, Row{"top", "Top view", "7"}, Row{"bottom", "Bottom view", "Ctrl+7"},
        Row{"iso", "Corner view", "0"}}) {
    rows.push_back({std::string("view.") + row.view, row.name,
                    "Turns about the middle of what is seen, at the same size.", "View", row.key, look, row.view});
  }
  rows.push_back({"view.projection", "Orthographic", "Parallel lines stay parallel.", "View", "5", switchProjection, "",
                  nullptr, isOrthographic});
  rows.push_back({"view.focus", "Focus on selected", "Fills the picture with it; with a drag the key sizes the tool.",
                  "View", "F", focusSelected});
  rows.push_back({"view.all", "Focus on everything", "Fills the picture with all that is visible.", "View",
                  "Home Shift+F", focusAll});
  rows.push_back(
      {"view.quickRing", "Quick ring",
       "Undo, redo, size, zoom and move around the cursor; a click of a pen's button or of the right mouse button.",
       "View", "Q", [](Context& c, Text) { c.state.wishes.quickRing = true; }});
  rows.push_back({"view.zoomIn", "Zoom in",
                  "Nearer to the middle of the picture; the wheel goes to what is under the pointer.", "View", "=",
                  [](Context& c, Text) { zoom(c, kZoomClicks); }});
  rows.push_back({"view.zoomOut", "Zoom out", "Away from the middle of the picture.", "View", "-",
                  [](Context& c, Text) { zoom(c, -kZoomClicks); }});
  rows.push_back({"view.section", "Section", "Cuts the picture open, not the clay.", "View", "K", switchSection, "",
                  nullptr, hasSection});
  // Switches of the View panel.
  for (const auto& row : lookRows()) {
    const auto* look = std::get_if<Switch<render::Look>>(&row);
    if (!look) continue;
    const std::string id(look->id);
    rows.push_back({"look." + id, std::string(look->name), std::string(look->help), "View", id == "xray" ? "Alt+X" : "",
                    switchLook, id, nullptr, isLook});
  }
  for (const auto& row : kShadings) {
    rows.push_back({"shading." + std::string(row.id), std::string(row.name), std::string(row.help), "View", "",
                    [](Context& c, Text id) { choose(kShadings, id, c.state.look.shading); }, std::string(row.id),
                    nullptr, [](const Context& c, Text id) { return isChosen(kShadings, id, c.state.look.shading); }});
  }
  for (const auto& row : kStereo) {
    rows.push_back({"stereo." + std::string(row.id), std::string(row.name), std::string(row.help), "View", "",
                    [](Context& c, Text id) { choose(kStereo, id, c.state.stereo.mode); }, std::string(row.id), nullptr,
                    [](const Context& c, Text id) { return isChosen(kStereo, id, c.state.stereo.mode); }});
  }
}

}  // namespace argil::studio
