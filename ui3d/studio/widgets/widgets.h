#pragma once
// Things that stand in the picture and can be grabbed: gizmo, guides, section, symmetry, rulers, boxes.

#include <memory>
#include <optional>
#include <string>

#include "haptics/threads/sample_ring.h"
#include "render/view/overlays.h"
#include "ui3d/studio/view/context.h"

namespace argil::studio {

/// A hand on a widget: a ray of the mouse or pen, or the tip of a stylus.
struct Grip {
  Vec3d origin = Vec3d::Zero(), direction = -Vec3d::UnitZ();  ///< Of a ray, length one.
  bool stylus = false;     ///< Then `origin` is the tip, and what is nearest to it within reach is grabbed.
  bool down = false;       ///< Button held.
  bool snapOff = false;    ///< A key held: no snapping for the moment.
  bool constrain = false;  ///< A key held: steps of 15° and of whole grid lines.
  bool adds = false;       ///< A key held: what is clicked joins the selection, or leaves it.
};

/// Draws and moves widgets. One thread.
class Widgets {
 public:
  Widgets();
  ~Widgets();
  Widgets(const Widgets&) = delete;
  Widgets& operator=(const Widgets&) = delete;

  /// Once a frame and once an event of the hand, mouse and stylus alike. True: a widget is under the hand or held, or
  /// something is being placed, so the clay is not to be touched. A drag sends edits that merge into one undo step.
  bool handle(Context& context, const Grip& grip);
  /// What is held goes back to where it was; else what is being placed is given up; else nothing is selected any more.
  void escape(Context& context);
  /// Enter: ends a curve that is being placed. False when there was none, or it has but one point.
  bool finish(Context& context);
  /// Delete: the point of a curve that was dragged last; while placing, the last point. False when there was none.
  bool removePoint(Context& context);
  [[nodiscard]] bool held() const;
  /// A click for which handle() was false: selects the thing under the ray, adds it (Grip::adds), or selects nothing
  /// any more. While something is placed handle() follows the presses itself; a click that comes without one adds a
  /// point. True when it was used.
  bool click(Context& context, const Grip& grip);
  /// Begins to place a new guide: "plane", "line", "point", "curve", "box", "ruler", "angle", "thickness" (a ruler
  /// through the clay). How: placing.h. It is selected once it is there. Nothing for another kind.
  void place(Context& context, const std::string& kind);
  [[nodiscard]] bool placing() const;
  /// What to do next while placing, for the status line; else empty.
  [[nodiscard]] std::string hint() const;

  /// What is to be drawn: fills, lines. Handles keep their size in the picture.
  void draw(const Context& context, render::Overlays& overlays) const;
  /// Texts at places in the picture: lengths, angles, names. Interface units.
  struct Label {
    float x = 0, y = 0;
    std::string text;
    render::Colour colour;
  };
  [[nodiscard]] std::vector<Label> labels(const Context& context) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace argil::studio
