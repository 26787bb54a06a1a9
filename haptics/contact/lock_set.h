#pragma once
// Locks that work together: where they let the tool be, without a jump when they begin or end.

#include <array>
#include <cstdint>

#include "haptics/base/subspace.h"
#include "haptics/scene/polyline.h"

namespace argil::haptics {

/// The common places of several locks; one that leaves no place in common with earlier ones does not work. A curve
/// holds alone: with another lock the earlier of the two works. When what they are changes, the set as a whole is moved
/// aside to pass through the proxy and slides back at a bounded speed; what the hand was held back by is let go as
/// slowly. Servo thread only; method: guides.md.
class LockSet {
 public:
  static constexpr int kMostLocks = 8;

  void reset() noexcept;

  // Once a tick: begin, add each in order, finish.
  void begin() ARGIL_REALTIME { count_ = 0, conflict_ = false; }
  void add(uint32_t id, const Subspace& set) ARGIL_REALTIME;
  /// The curve must live until the next begin().
  void add(uint32_t id, const Polyline& curve) ARGIL_REALTIME;
  /// `slideMm`: how far the set may slide in this tick. `lostHold`: something else that held the proxy is gone.
  void finish(const Vec3d& proxy, const Vec3d& hand, double slideMm, bool lostHold) ARGIL_REALTIME;

  [[nodiscard]] bool locked() const noexcept { return count_ > 0; }
  /// Some lock leaves no place in common with earlier ones and does not work.
  [[nodiscard]] bool conflict() const noexcept { return conflict_; }
  /// The set is where it belongs and the hand is followed: nothing slides.
  [[nodiscard]] bool settled() const noexcept { return aside_.isZero(0) && back_.isZero(0); }

  /// Where the proxy is to go for a hand: the hand itself, less what is still being let go, and on a curve the nearest
  /// place that a bead gets to. Off the set all the same for planes and lines.
  [[nodiscard]] Vec3d goal(const Vec3d& hand) const ARGIL_REALTIME;
  /// The set at its place nearest to p: all of it, of a curve the tangent there.
  [[nodiscard]] Subspace at(const Vec3d& p) const ARGIL_REALTIME;
  /// The nearest place of the set itself; idempotent to rounding.
  [[nodiscard]] Vec3d snap(const Vec3d& p) const ARGIL_REALTIME;

 private:
  struct Lock {
    uint32_t id = 0;
    Subspace set;
    const Polyline* curve = nullptr;
    uint64_t curveId = 0;
    [[nodiscard]] bool same(const Lock& o) const noexcept { return id == o.id && curveId == o.curveId && set == o.set; }
  };
  bool meet() ARGIL_REALTIME;
  [[nodiscard]] Vec3d snapTrue(const Vec3d& p) const ARGIL_REALTIME;

  std::array<Lock, kMostLocks> locks_, before_;
  int count_ = 0, countBefore_ = 0;
  bool conflict_ = false;
  Subspace flat_;  // The common places, unless it is a curve that holds.
  const Polyline* curve_ = nullptr;
  Polyline::Place bead_;         // Of the proxy on the curve.
  double runMm_ = 0;             // How far along the curve the proxy goes in this tick, at most.
  Vec3d aside_ = Vec3d::Zero();  // How far the set is from where it belongs.
  Vec3d back_ = Vec3d::Zero();   // From the hand to where it is taken to be.
  Vec3d hand_ = Vec3d::Zero();
};

}  // namespace argil::haptics
