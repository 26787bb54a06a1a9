#pragma once
// A guide that is being made, click by click.

#include <optional>
#include <string>
#include <vector>

#include "ui3d/studio/widgets/snap.h"
#include "ui3d/studio/widgets/widgets.h"

namespace argil::studio {

/// plane: one click, tangent to the clay there. point: one. thickness: one, a ruler through the clay along its normal.
/// line: two; twice at one place stands on the clay along its normal. ruler: two. angle: three, the corner second.
/// curve: as many as wanted; ends with finish(), a second click at the last point, or one at the first, which closes
/// it. box: press, drag, release. Where there is no clay points lie on the ground, or before the eye where the ground
/// is seen from its edge. Two clicks may be one drag. Constrain: planes and lines take the nearest axis of the world.
class Placing {
 public:
  /// Nothing for an unknown kind.
  static bool knows(const std::string& kind);
  explicit Placing(std::string kind) : kind_(std::move(kind)) {}

  /// The hand is there. Follows presses and releases; true when the guide is complete.
  bool follow(const World& world, const Grip& grip);
  /// A click that came without a press. True when the guide is complete.
  bool click(const World& world, const Grip& grip);
  /// Enter: true when what there is makes a guide.
  bool finish(const World& world);
  /// Takes the last point back; false when there was none.
  bool stepBack();

  /// What there is, with the place of the hand as its next point; nothing before there is enough to see.
  [[nodiscard]] std::optional<engine::Guide> preview(const World& world) const;
  /// After completion.
  [[nodiscard]] std::optional<engine::Guide> result(const World& world) const;
  [[nodiscard]] const std::vector<Vec3d>& points() const { return points_; }
  [[nodiscard]] const std::optional<Snap>& snap() const { return snap_; }
  /// Where the hand is.
  [[nodiscard]] const std::optional<Vec3d>& spot() const { return spot_; }
  /// What to do next, for the status line: "Click where the ruler begins".
  [[nodiscard]] std::string hint() const;

 private:
  void look(const World& world, const Grip& grip);
  bool addPoint(const World& world);
  [[nodiscard]] size_t needed() const;
  [[nodiscard]] std::optional<engine::Guide> make(const World& world, const std::vector<Vec3d>& points) const;

  std::string kind_;
  std::vector<Vec3d> points_;
  Vec3d normal_ = Vec3d::Zero();  // Of the clay at the first point; zero: none.
  Vec3d spotNormal_ = Vec3d::Zero();
  std::optional<Vec3d> spot_, pressedAt_;
  std::optional<Snap> snap_;
  bool wasDown_ = false, closed_ = false, constrain_ = false;
};

}  // namespace argil::studio
