#pragma once
// The constraint proxy: a ball that follows a goal as far as what is around lets it.

#include <array>
#include <cstdint>

#include "haptics/contact/active_set.h"
#include "haptics/contact/guides.h"
#include "haptics/scene/surroundings.h"

namespace argil::haptics {

/// A ball of any radius on the surfaces around it (Ruspini). Invariants: it never overlaps them by more than a few
/// hundredths of a voxel, unless something new left it inside (then leave() moves it out at a bounded speed); follow()
/// never increases |proxy − goal| by more than rounding of that overlap, 0.01 voxels. One thread, the servo's. Recipe,
/// tolerances and figures: NOTES.md, "Ball contact".
class Proxy {
 public:
  /// Forgets everything; the ball is free at `at`.
  void reset(const Vec3d& at) noexcept;
  /// At the beginning of a tick: what is around, what locks it, how large the ball is; lengths are counted in
  /// around.resolutionMm(). A ball that locks hold somewhere else is there from now on, whatever is in the way.
  void begin(Surroundings& around, const Guides& guides, const Quality& quality, double radiusMm) ARGIL_REALTIME;
  /// What is around is new: keeps the contacts that still hold.
  void refresh() ARGIL_REALTIME;

  /// What holds the ball from going straight to a goal, as it stands now.
  struct Holding {
    Vec3d place = Vec3d::Zero();  ///< Nearest to the goal that the planes of all contacts allow.
    /// From the goal (its nearest place on the locks) to where the planes' smooth normals hold it, mm: along the normal
    /// force.
    Vec3d push = Vec3d::Zero();
    bool feasible = true;            ///< False: the planes leave no place in common; the harder held.
    bool conflict = false;           ///< Locks or keep-outs contradict each other or what is softer.
    std::array<int, 3> thing{};      ///< What each active plane belongs to.
    std::array<double, 3> share{};   ///< Length of each one's part of `push`, mm.
    std::array<HalfSpace, 3> plane;  ///< Each one, for the ball's centre, turned to its smooth normal.
    std::array<Vec3d, 3> point;      ///< Where each one touches the ball.
    int count = 0;                   ///< Active planes, 0 to 3.
  };
  [[nodiscard]] Holding holding(const Vec3d& goal) ARGIL_REALTIME;

  /// How the ball took it that things moved.
  struct Carried {
    bool pushed = false;  ///< Something that moved held the ball or came to hold it.
    /// False: a limit was met, or the ball is held from all sides. The rest of the motion waits for the next tick.
    bool whole = true;
  };
  /// Once a tick, before anything else moves the ball: what moves goes its way of this tick
  /// (Surroundings::startMotion), and the ball with it, as seen from what it touches; it pushes the ball aside and is
  /// never passed by, however fast. `gentleMm`: how far what may have jumped pushes at most.
  Carried carry(double gentleMm) ARGIL_REALTIME;

  /// True when something new overlaps the ball.
  [[nodiscard]] bool caught() const noexcept;
  /// Out along the nearest surface by at most `stepMm`; false while so deep that no surface is in reach.
  bool leave(double stepMm) ARGIL_REALTIME;
  /// Towards the goal in straight steps that end at first contact, then along the surfaces. `held`: holding(goal) as it
  /// is now. False when a limit of the search was met: the next tick goes on.
  bool follow(const Vec3d& goal, const Holding& held) ARGIL_REALTIME;

  [[nodiscard]] const Vec3d& at() const noexcept { return proxy_; }
  /// Lower bound of the distance from the centre to what is around, mm; exact while touching.
  [[nodiscard]] double clearanceMm() const noexcept { return clearance_; }
  /// Nearest-point searches since begin().
  [[nodiscard]] int searches() const noexcept { return searches_; }

 private:
  static constexpr int kMaxContacts = kMaxHalfSpaces;
  struct ContactPoint {
    Vec3d point = Vec3d::Zero();   // Of a surface that holds the ball or nearly does,
    Vec3d smooth = Vec3d::Zero();  // its smooth normal, zero when there is none,
    int thing = -1;
    bool smoothKnown = false;
  };

  Around search(const Vec3d& p) ARGIL_REALTIME;
  void note(const Around& found, double mergeCosine) ARGIL_REALTIME;
  void place(const Vec3d& p, double clearanceMm) ARGIL_REALTIME;
  void prune() ARGIL_REALTIME;
  void smoothen(ContactPoint& contact, const Vec3d& normal) ARGIL_REALTIME;
  [[nodiscard]] Vec3d outwards() const ARGIL_REALTIME;
  void leaveDepth(double step) ARGIL_REALTIME;
  bool step(const Vec3d& goal, const Holding& held, int attempts) ARGIL_REALTIME;
  [[nodiscard]] bool touches(const ContactPoint& contact) const ARGIL_REALTIME;
  bool carryOn(double way, Carried& result) ARGIL_REALTIME;

  [[nodiscard]] Vec3d snapped(const Vec3d& p) const ARGIL_REALTIME;

  Surroundings* around_ = nullptr;
  const Guides* guides_ = nullptr;
  bool locked_ = false;
  Vec3d proxy_ = Vec3d::Zero();
  double radius_ = 1, voxel_ = 1, keep_ = 0;
  double clearance_ = 0;
  std::array<ContactPoint, kMaxContacts> contacts_;
  int contactCount_ = 0;
  bool stuck_ = false;  // The last tick moved nothing though the goal asked for it.
  int part_ = 0;        // Step of the tick; in the first one an overlap within the tolerance is given back.
  bool smoothNormals_ = true;
  int steps_ = 8, mostSearches_ = 20, searches_ = 0;
  int escapeRing_ = 0, escapeRay_ = -1;
};

}  // namespace argil::haptics
