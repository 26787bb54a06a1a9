#pragma once
// The widgets without renderer and workbench: what Widgets does, in a World.

#include <array>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "ui3d/studio/widgets/build.h"
#include "ui3d/studio/widgets/drag.h"
#include "ui3d/studio/widgets/placing.h"
#include "ui3d/studio/widgets/widgets.h"

namespace argil::studio {

/// See Widgets for what the members do. One thread.
class WidgetSet {
 public:
  bool handle(World& world, const Grip& grip);
  void escape(World& world);
  bool finish(World& world);
  bool removePoint(World& world);
  [[nodiscard]] bool held() const { return drag_.has_value(); }
  bool click(World& world, const Grip& grip);
  void place(World& world, const std::string& kind);
  [[nodiscard]] bool placing() const { return placing_.has_value(); }
  [[nodiscard]] std::string hint() const { return placing_ ? placing_->hint() : std::string(); }

  void draw(const World& world, render::Overlays& overlays) const;
  [[nodiscard]] std::vector<Widgets::Label> labels(const World& world) const;

  /// What is there to be grabbed, for tests.
  [[nodiscard]] std::vector<Handle> handles(const World& world) const;
  [[nodiscard]] const std::optional<Drag>& drag() const { return drag_; }

 private:
  /// What was let go is ahead of the edit thread for a moment.
  struct Settling {
    Target target;
    Subject subject;
    std::optional<Vec3d> pivot;
    double untilS = 0;
  };
  [[nodiscard]] engine::Document shown(const World& world) const;
  [[nodiscard]] Build build(const World& world, const engine::Document& shown) const;
  void press(World& world, const Handle& handle, const Vec3d& at, const Grip& grip);
  void letGo(World& world);
  void complete(World& world);
  void selectNew(World& world);
  [[nodiscard]] static std::vector<std::pair<Target, Subject>> othersThan(const World& world, const Handle& handle);

  std::array<std::optional<Handle>, 2> hover_;  // Of the mouse, of the stylus.
  std::array<bool, 2> wasDown_{}, ignored_{};   // Ignored: until the button is up, after an escape.
  std::optional<Drag> drag_;
  std::vector<std::pair<Target, Subject>> others_;  // That the drag takes along, as they were when it began.
  std::optional<Settling> settling_;
  std::optional<Placing> placing_;
  bool placedByPress_ = false;  // The click that follows was taken already.
  engine::Id expected_ = 0;     // Of a guide that was placed and is on its way.
  double expectedUntilS_ = 0;
  std::optional<std::pair<engine::Id, size_t>> point_;  // Of a curve: dragged last, what Delete takes.
  uint64_t drags_ = 0;
};

}  // namespace argil::studio
