#pragma once
// A handle in the hand, from the press to the release.

#include <optional>
#include <string>

#include "ui3d/studio/widgets/handle.h"
#include "ui3d/studio/widgets/snap.h"

namespace argil::studio {

/// What was under the hand at the press stays under it: nothing jumps, in whatever place of a handle it was grabbed.
class Drag {
 public:
  /// `grab`: the place on the handle that the hand took.
  Drag(const Handle& handle, const Vec3d& grab, Subject start, const Grip& grip, const ScreenMap& screen,
       std::string merge);

  /// Where the hand has brought it. False when nothing changed since the last time. Nothing does before the hand has
  /// moved a little.
  bool follow(const World& world, const engine::Document& shown, const Grip& grip);

  [[nodiscard]] const Handle& handle() const { return handle_; }
  [[nodiscard]] const Subject& start() const { return start_; }
  [[nodiscard]] const Subject& now() const { return now_; }
  [[nodiscard]] const Change& change() const { return change_; }
  [[nodiscard]] const std::optional<Snap>& snap() const { return snap_; }
  [[nodiscard]] const std::string& merge() const { return merge_; }
  [[nodiscard]] bool stylus() const { return stylus_; }
  [[nodiscard]] bool changed() const { return changed_; }
  /// Where the anchor is now.
  [[nodiscard]] Vec3d anchor() const { return handle_.anchor + change_.move; }
  /// "Move Plane 1".
  [[nodiscard]] std::string label(const engine::Document& document) const;
  /// What the hand did, in numbers: "12.50 mm", "45.0°", "× 1.20".
  [[nodiscard]] std::string text() const;

 private:
  /// The hand, shifted so that it goes through `grab_` at the press.
  struct Hand {
    Ray ray;
    double x = 0, y = 0;
    Vec3d tip = Vec3d::Zero();
  };
  [[nodiscard]] Hand shifted(const Grip& grip, const ScreenMap& screen) const;
  [[nodiscard]] std::optional<double> alongLine(const Hand& hand, const Vec3d& through, const Vec3d& axis,
                                                const ScreenMap& screen) const;
  [[nodiscard]] std::optional<Vec3d> onPlane(const Hand& hand, const Vec3d& normal, const ScreenMap& screen) const;
  [[nodiscard]] std::optional<Change> measure(const World& world, const engine::Document& shown, const Grip& grip,
                                              std::optional<Snap>& snap) const;
  [[nodiscard]] std::optional<Change> measureMove(const World& world, const engine::Document& shown, const Grip& grip,
                                                  const Hand& hand, std::optional<Snap>& snap) const;
  [[nodiscard]] std::optional<Change> measureTurn(const World& world, const engine::Document& shown, const Grip& grip,
                                                  const Hand& hand, std::optional<Snap>& snap) const;

  Handle handle_;
  Vec3d grab_;
  Subject start_, now_;
  std::string merge_;
  bool stylus_;
  Vec3d shift_ = Vec3d::Zero();    // Units in the window (x, y), or mm of a tip.
  Vec3d pressed_ = Vec3d::Zero();  // Where the hand was, in the same.
  bool edgeOn_ = false;            // A turn whose circle is a line in the picture: it follows the tangent.
  bool moved_ = false, changed_ = false;
  Change change_;
  std::optional<Snap> snap_;
};

}  // namespace argil::studio
