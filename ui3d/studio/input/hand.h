#pragma once
// Mouse and pen as a hand: lines of sight become places of the stylus, at the speed at which they were drawn.

#include <deque>
#include <optional>
#include <vector>

#include "engine/session/workbench.h"
#include "render/view/look.h"
#include "ui3d/studio/view/camera.h"
#include "ui3d/studio/view/clay_ray.h"
#include "ui3d/studio/view/event.h"

namespace argil::studio {

/// A stroke by mouse or pen. Each motion is handed on at its own time plus a lag that stays the same for the stroke, so
/// that its shape and speed do not depend on how often pictures are drawn. One thread.
class Hand {
 public:
  explicit Hand(engine::Workbench& bench) : bench_(bench) {}

  /// What a stroke keeps from its beginning to its end.
  struct Stroke {
    PinnedClay clay;
    Camera camera;
    float width = 1, height = 1;  ///< Of the window, interface units.
    std::optional<render::Section> section;
    double radiusMm = 1;
    bool cuts = false;              ///< The tip's place is what is cut: a pen's pressure rules its depth.
    double depthPart = 0;           ///< Of the radius: how deep its centre goes under the surface.
    std::optional<double> otherMm;  ///< Along the first line of sight: a part in front.
  };

  /// Where a straight line over the window meets the clay, world mm, from its first place to where the clay ends.
  /// `deep`: as deep under the surface as a stroke goes.
  [[nodiscard]] static std::vector<Vec3d> placesUnder(const Stroke& stroke, const Event& from, const Event& to,
                                                      bool deep);

  /// The cursor is here and no button is down; `surfaceMm`: along the ray, not finite when nothing is there.
  void hover(const Camera::Ray& ray, double surfaceMm, const Event& event);
  /// The stroke begins with a `press` event that was made at its timeS and is handled now.
  void begin(Stroke stroke, const Event& event, double nowS);
  void move(const Event& event);
  void end(const Event& event);
  /// Out of the window.
  void leave();

  /// From the press to the moment when the release has been handed on.
  [[nodiscard]] bool active() const { return stroke_.has_value(); }
  [[nodiscard]] bool pressed() const { return stroke_.has_value() && !released_; }
  /// Hands on what is due; returns when the next is due, infinity when nothing waits.
  double pump(double nowS);
  /// Where the tip was sent last, world.
  [[nodiscard]] const Vec3d& place() const { return place_; }

 private:
  struct Due {
    double timeS = 0;
    haptics::PointerSample sample;
    bool last = false;
  };
  haptics::PointerSample sampleOf(const Event& event, bool down);
  void push(double timeS, const haptics::PointerSample& sample, bool last = false);
  void feed(const haptics::PointerSample& sample);

  engine::Workbench& bench_;
  std::optional<Stroke> stroke_;
  std::deque<Due> due_;
  double lagS_ = 0, lastDueS_ = 0;
  double lastSurfaceMm_ = 0;
  bool released_ = false;
  Vec3d place_ = Vec3d::Zero();
};

}  // namespace argil::studio
