#pragma once
// All that stands in the picture at one moment: handles, lines, faces, texts. Each kind of widget adds its own.

#include <string>
#include <vector>

#include "ui3d/studio/widgets/handle.h"

namespace argil::studio {

namespace widget_colours {
inline constexpr render::Colour kX{0.93f, 0.30f, 0.32f, 1}, kY{0.46f, 0.80f, 0.25f, 1}, kZ{0.30f, 0.56f, 0.98f, 1};
inline constexpr render::Colour kHandle{0.97f, 0.97f, 0.99f, 1}, kHot{1.00f, 0.82f, 0.22f, 1},
    kSnap{1.00f, 0.45f, 0.85f, 1};
inline constexpr render::Colour kSection{0.66f, 0.76f, 0.88f, 1}, kWorkspace{0.55f, 0.80f, 0.90f, 1};
}  // namespace widget_colours
[[nodiscard]] render::Colour axisColour(int axis);
[[nodiscard]] render::Colour faded(render::Colour colour, float alpha);
/// By how it is felt: seen, lock, well, keep-out.
[[nodiscard]] render::Colour guideColour(const engine::Guide& guide);

/// "12.50 mm", "85 µm", "1.25 m".
[[nodiscard]] std::string lengthText(double mm);
/// "45.0°".
[[nodiscard]] std::string angleText(double rad);

struct Build {
  const World& world;
  const engine::Document& document;  ///< As it is to be shown: what is dragged is ahead of the edit thread.
  std::vector<Handle> handles;
  std::vector<render::Polyline> lines;
  std::vector<render::Fill> fills;
  struct Text {
    Vec3d at;
    std::string text;
    render::Colour colour;
  };
  std::vector<Text> texts;
  std::vector<render::PlaneMark> planes;

  void line(std::vector<Vec3d> points, render::Colour colour, float width = 2,
            render::Depth depth = render::Depth::xray);
  void closedLine(std::vector<Vec3d> points, render::Colour colour, float width = 2,
                  render::Depth depth = render::Depth::xray);
  void fill(std::vector<Vec3d> triangles, render::Colour colour, render::Depth depth = render::Depth::xray);
  void text(const Vec3d& at, std::string text, render::Colour colour);
  /// mm of an interface unit there.
  [[nodiscard]] double unit(const Vec3d& at) const { return world.screen.unitMm(at); }
  /// Size of what there is, for things that have none: never 0.
  [[nodiscard]] double extentMm() const;
};

/// How a guide is to be shown.
struct Stance {
  bool selected = false;
  bool grabbed = true;  ///< Its handles and body may be: neither locked nor being placed.
  bool gizmo = false;   ///< A gizmo stands on it: what that does has no handle of its own.
  float strength = 1;   ///< Of its colours: previews and hidden ones are faint.
};

/// A rectangle about which several widgets are built.
struct Sheet {
  Vec3d centre, x, y;   ///< Unit axes in it.
  double halfX, halfY;  ///< mm.
  [[nodiscard]] Vec3d normal() const { return x.cross(y); }
  /// −1 to 1 in it.
  [[nodiscard]] Vec3d at(double u, double v) const { return centre + u * halfX * x + v * halfY * y; }
  [[nodiscard]] std::vector<Vec3d> corners() const { return {at(-1, -1), at(1, -1), at(1, 1), at(-1, 1)}; }
  [[nodiscard]] std::vector<Vec3d> triangles() const;
  /// A narrow band along the edge.
  [[nodiscard]] std::vector<Vec3d> rim() const;
};
/// An arrow along the sheet's normal from `foot`, which moves the target; two arcs at its edges that tilt it.
void sheetHandles(Build& build, const Sheet& sheet, const Target& target, const Vec3d& foot, render::Colour colour,
                  bool tilts);

// Each kind of widget, in a file of its own.
void buildPlane(Build& build, const engine::Guide& guide, const Stance& stance);
void buildLine(Build& build, const engine::Guide& guide, const Stance& stance);
void buildPoint(Build& build, const engine::Guide& guide, const Stance& stance);
void buildCurve(Build& build, const engine::Guide& guide, const Stance& stance);
void buildKeepOutBox(Build& build, const engine::Guide& guide, const Stance& stance);
void buildRuler(Build& build, const engine::Guide& guide, const Stance& stance);
void buildAngle(Build& build, const engine::Guide& guide, const Stance& stance);
void buildGuide(Build& build, const engine::Guide& guide, const Stance& stance);
void buildSection(Build& build);
void buildSymmetry(Build& build);
void buildWorkspaceBox(Build& build);
void buildPrintBed(Build& build);
void buildPegs(Build& build);
/// Where the bed's middle lies on the ground: below the middle of what is seen, or, where that is larger, with its
/// corner.
[[nodiscard]] Vec3d printBedMiddle(const render::Box& clay, const Vec3d& bedMm);
void buildLattice(Build& build);
void buildPlaneCut(Build& build);
void buildDrawnCurve(Build& build);
/// For the selected thing, about `pivot`. `axes`: unit, right-handed.
void buildGizmo(Build& build, const Target& target, GizmoMode mode, const Vec3d& pivot, const Eigen::Matrix3d& axes,
                bool sized);

/// Everything of a document and the studio. `pivot`: of a gizmo in a drag, instead of the thing's own.
[[nodiscard]] Build buildAll(const World& world, const engine::Document& shown, const std::optional<Vec3d>& pivot);
/// Where a gizmo on this thing stands.
[[nodiscard]] std::optional<Vec3d> pivotOf(const World& world, const engine::Document& shown, engine::Id id);

/// Points of a circle or a part of it, first and last included: centre + r (cos a x + sin a y).
[[nodiscard]] std::vector<Vec3d> arc(const Vec3d& centre, const Vec3d& x, const Vec3d& y, double radius, double from,
                                     double to, int steps);
/// What a curve guide looks like; the points themselves where haptics would refuse them. `starts`: where each given
/// point is in it.
[[nodiscard]] std::vector<Vec3d> sampleCurve(const std::vector<Vec3d>& points, bool closed,
                                             std::vector<size_t>* starts = nullptr);

/// Draws handles, those that are hot (under a hand or held) in another colour.
void drawHandles(Build& build, const std::vector<const Handle*>& hot);

}  // namespace argil::studio
