#pragma once
// The proxy on a textured surface: its place and force, tick by tick, without ever giving energy.

#include <array>

#include "haptics/base/pose.h"
#include "haptics/contact/active_set.h"
#include "haptics/scene/texture.h"

namespace argil::haptics {

/// A plane that holds the smooth proxy, and what lies on it.
struct TexturedPlane {
  HalfSpace plane;                   ///< Of the ball's centre, world mm, as it was given to nearestAllowed.
  const Texture* texture = nullptr;  ///< Null: smooth.
  const Pose* pose = nullptr;        ///< Of the piece that the texture sticks to; needed with a texture.
  Vec3d at = Vec3d::Zero();          ///< Where the ball touches, world mm.
};

/// Displaces the planes of a smooth contact by the heights of their textures, once a tick after the smooth proxy is
/// known. The force is that of the potential ½k|t − u|² over the displaced place t and the hand u: the spring to t,
/// tilted by the slopes; for one plane k(d + h)(n − ∇h). What is too short for the proxy's speed fades:
/// nothing above 0.4 of the servo rate is rendered. The textured proxy gives the hand no more energy than the smooth
/// one does, but for what it takes to climb the texture once: beyond that a bump is climbed as far as the hand has paid
/// for it. Method: textures.md. One thread, the servo's.
class TexturePath {
 public:
  struct Place {
    Vec3d proxy = Vec3d::Zero();    ///< Displaced, world mm.
    Vec3d stretch = Vec3d::Zero();  ///< Force over stiffness, mm, world.
    int planes = 0;                 ///< Active ones among the displaced.
  };

  /// Nothing is touched: the next touch begins anew.
  void reset() noexcept { begun_ = false; }

  /// `proxy`: the smooth one of this tick, held by `planes` (at most kMaxHalfSpaces) against `hand`; friction may hold
  /// it elsewhere than nearest to the hand. No planes: nothing is touched. Cost: 0.1 to 0.3 µs with a texture.
  Place advance(const Vec3d& proxy, const Vec3d& hand, const TexturedPlane* planes, int count) ARGIL_REALTIME;

  /// What the hand has paid and the texture may give back, over the stiffness, mm²; negative: owed.
  [[nodiscard]] double storedMm2() const noexcept { return stored_; }

 private:
  struct Slot {  // A texture that is touched, in its piece's frame.
    const Texture* texture = nullptr;
    Vec3d at = Vec3d::Zero();
  };
  struct Walk {  // The same in this tick.
    int plane;
    Vec3d from, to, normal;
  };
  int match(const Vec3d& proxy, const TexturedPlane* planes, int count, Walk* walks) const ARGIL_REALTIME;

  bool begun_ = false;
  std::array<Slot, kMaxHalfSpaces> slots_;
  int slotCount_ = 0;
  double travel_ = 0;                                                              // Of a tick, smoothed, mm.
  Vec3d hand_ = Vec3d::Zero(), smooth_ = Vec3d::Zero(), stretch_ = Vec3d::Zero();  // Of the last tick.
  double energy_ = 0;                                                              // ½|t − u|² of the last tick.
  double stored_ = 0;
};

}  // namespace argil::haptics
