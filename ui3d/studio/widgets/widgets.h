#pragma once
// Things that stand in the picture and can be grabbed: gizmo, guides, section, symmetry, rulers, boxes.

#include <memory>
#include <optional>
#include <string>

#include "haptics/sample_ring.h"
#include "render/overlays.h"
#include "ui3d/studio/context.h"

namespace argil::studio {

/// A hand on a widget: a ray of the mouse or pen, or the tip of a stylus.
struct Grip {
  Vec3d origin = Vec3d::Zero(), direction = -Vec3d::UnitZ();  ///< Of a ray, length one.
  bool stylus = false;       ///< Then `origin` is the tip, and what is nearest to it within reach is grabbed.
  bool down = false;         ///< Button held.
  bool snapOff = false;      ///< A key held: no snapping for the moment.
  bool constrain = false;    ///< A key held: steps of 15° and of whole grid lines.
};

/// Draws and moves widgets. One thread.
class Widgets {
 public:
  Widgets();
  ~Widgets();
  Widgets(const Widgets&) = delete;
  Widgets& operator=(const Widgets&) = delete;

  /// Once a frame and once an event of the hand. True: a widget is under the hand or held, so the clay is not to be touched.
  /// A drag sends edits that merge into one undo step; escape() puts everything back.
  bool handle(Context& context, const Grip& grip);
  void escape(Context& context);
  [[nodiscard]] bool held() const;
  /// A click that met no widget: selects the thing under the ray, or adds a point to what is being placed. True when it was used.
  bool click(Context& context, const Grip& grip);
  /// Begins to place a new guide by clicks ("plane", "line", "point", "curve", "box", "ruler", "angle").
  void place(Context& context, const std::string& kind);
  [[nodiscard]] bool placing() const;

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
