#pragma once
// All guides of a scene, as contact feels them.

#include <array>
#include <span>

#include "haptics/contact/contact.h"
#include "haptics/contact/keep_out.h"
#include "haptics/contact/lock_set.h"
#include "haptics/contact/soft_guide.h"

namespace argil::haptics {

/// Locks, keep-outs and forces of Scene::guides from tick to tick. Whatever begins, ends, moves or contradicts, the
/// tool does not jump: every such change is spread over time. Costs nothing where there are no guides. Servo thread
/// only; all memory is its own, half a megabyte: not for the stack. Method: guides.md.
class Guides {
 public:
  /// Forgets everything: the next scene's guides begin anew.
  void reset() noexcept;

  /// Once a tick and before the rest: which guides work, and what they do. `input`: with the device's own limits, at
  /// the hand. `proxy`: where the last tick left it (the hand, in the first). `touchNormal`: unit normal of the surface
  /// that the ball touches, zero when it touches none; a lock to the normal begins there. Cost: some 0.03 µs a lock or
  /// force; a well at a curve about 0.2 µs, one at a piece a search of its surface.
  void begin(const Scene& scene, const Contact::Input& input, const Vec3d& proxy,
             const Vec3d& touchNormal) ARGIL_REALTIME;

  /// Some lock works.
  [[nodiscard]] bool locked() const noexcept { return locks_.locked(); }
  /// Where the proxy is to go, in place of the hand (LockSet::goal). Differs from the hand even without locks for as
  /// long as one that ended is let go: the spring from the proxy to the hand itself is then felt though nothing is
  /// touched.
  [[nodiscard]] Vec3d goal(const Vec3d& hand) const ARGIL_REALTIME { return locks_.goal(hand); }
  /// A lock or a hold that ended is still being let go, or the locked set slides to its place.
  [[nodiscard]] bool settling() const noexcept { return !locks_.settled(); }
  /// The locked set near p, of a curve its tangent: ask again after each step along it.
  [[nodiscard]] Subspace lockAt(const Vec3d& p) const ARGIL_REALTIME { return locks_.at(p); }
  /// Nearest place of the locked set itself; p without locks.
  [[nodiscard]] Vec3d snap(const Vec3d& p) const ARGIL_REALTIME { return locks_.snap(p); }

  /// Keep-outs that work; valid until the next begin().
  [[nodiscard]] std::span<Touchable* const> keepOuts() const noexcept {
    return {keepOuts_.data(), size_t(keepOutCount_)};
  }
  /// They are not what they were in the last tick: what contact knows of them is old.
  [[nodiscard]] bool keepOutsChanged() const noexcept { return keepOutsChanged_; }

  /// Wells and ambient forces on the hand, N, world directions; no more than half of the device's peak.
  [[nodiscard]] const Vec3d& force() const noexcept { return force_; }
  /// kGuideConflict or nothing.
  [[nodiscard]] uint32_t flags() const noexcept;

  /// Of locks, in peaks a second: 6 % of the peak in 10 ms; 7 % is felt (Pang et al. 1991).
  static constexpr double kGuideForcePerS = 6;
  static constexpr double kSlideMms = 30;            ///< Of locked sets, at the hand.
  static constexpr double kPointingSlideMms = 4000;  ///< The same where no motor pulls a hand along.

 private:
  struct State {
    uint32_t id = 0;
    size_t kind = 0;
    bool works = false;
    // Soft guides.
    bool caught = false;
    double weight = 0;
    Vec3d force = Vec3d::Zero();  // Given in the last tick.
    SoftMemory memory;
    // A lock to the normal.
    bool held = false;
    Vec3d point = Vec3d::Zero(), normal = Vec3d::UnitZ();
    KeepOut keepOut;
  };

  void match(const Scene& scene, bool& lostHold) ARGIL_REALTIME;
  void drop(State& state, bool& lostHold) ARGIL_REALTIME;
  void addLock(const Guide& guide, State& state, const Vec3d& proxy, const Vec3d& touchNormal) ARGIL_REALTIME;
  void addLockOfWell(const Guide& guide, const Vec3d& hand) ARGIL_REALTIME;
  void addForce(const Guide& guide, State& state, const Scene& scene, TouchableClay* clay, const Contact::Input& input,
                const SoftLimits& limits) ARGIL_REALTIME;

  // The first stateCount_ as the scene's guides; room for those just gone.
  std::array<State, 2 * kMaxGuides> states_;
  size_t stateCount_ = 0;
  std::array<TouchableClay, kMaxPieceGuides> clays_;  // The n-th for the n-th guide that names a piece.
  LockSet locks_;
  std::array<Touchable*, kMaxGuides> keepOuts_{};
  int keepOutCount_ = 0;
  bool keepOutsChanged_ = false;
  Vec3d force_ = Vec3d::Zero();
  Vec3d carry_ = Vec3d::Zero();  // What guides gave that are gone or leapt: let go little by little.
  Vec3d at_ = Vec3d::Zero();     // Of the hand in the last tick.
  double explained_ = 0;         // Change of force that the hand's way explains, of any one soft guide, N.
  bool begun_ = false;
  // Soft guides that were on their way to full strength in the last tick, in this one.
  int rising_ = 1, risingNow_ = 0;
};

}  // namespace argil::haptics
