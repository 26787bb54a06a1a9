#pragma once
// A ball that touches and cuts clay: the proxy and its force.

#include <array>
#include <cstdint>
#include <span>

#include "haptics/active_set.h"
#include "haptics/contact.h"
#include "haptics/cutting.h"
#include "haptics/touchable.h"

namespace argil::haptics {

/// Constraint proxy (Ruspini) for a ball of any radius on the clay's surface, and the cutting law where the tool changes it.
/// Invariants: the proxy's ball never overlaps the clay by more than a few hundredths of a voxel, unless a new version left it inside
/// (then it moves out at a bounded speed); a tick without a new version never increases |proxy − hand| by more than
/// rounding of that overlap, 0.01 voxels. One thread, the servo's. Recipe, tolerances and figures: NOTES.md, "Ball contact".
class BallContact final : public Contact {
 public:
  void reset() noexcept override;
  Output tick(const Scene& scene, const Input& input) ARGIL_REALTIME override;

  /// Distance from the proxy's centre to the surface as the contact knows it: a lower bound, mm; exact while touching.
  [[nodiscard]] double clearanceMm() const noexcept { return clearance_; }
  /// Nearest-point searches of the last tick.
  [[nodiscard]] int searches() const noexcept { return searches_; }

 private:
  enum class Mode : uint8_t { touch, cut, settle, add };
  static constexpr int kMaxContacts = kMaxHalfSpaces;

  Nearest search(const Vec3d& p) ARGIL_REALTIME;
  void note(const Nearest& nearest, double mergeCosine) ARGIL_REALTIME;
  void place(const Vec3d& p, double clearanceMm) ARGIL_REALTIME;
  void prune() ARGIL_REALTIME;
  ActiveSet target(const Vec3d& goal) const ARGIL_REALTIME;
  bool leave(double periodS, double stiffness, double peakN) ARGIL_REALTIME;
  void leaveDepth(double step) ARGIL_REALTIME;
  void follow(const Vec3d& hand, uint32_t& flags) ARGIL_REALTIME;
  void step(const Vec3d& hand, int attempts, uint32_t& flags) ARGIL_REALTIME;
  void changeMode(const Scene& scene, const Input& input) ARGIL_REALTIME;
  void touch(const Input& input, bool changed, Output& out) ARGIL_REALTIME;
  void cut(const Scene& scene, const Input& input, Output& out) ARGIL_REALTIME;

  std::array<TouchableClay, kMaxPieces> pieces_;
  std::span<TouchableClay> used_;
  Mode mode_ = Mode::touch;
  bool begun_ = false;
  Vec3d proxy_ = Vec3d::Zero();
  double radius_ = 1, voxel_ = 1;
  double clearance_ = 0;  // Lower bound of the signed distance from the proxy to the surface.
  std::array<Vec3d, kMaxContacts> contacts_;  // Points of the surface that hold the ball or nearly do.
  int contactCount_ = 0;
  Vec3d near_ = Vec3d::Zero();  // What the last search found: the hint of the next.
  bool stuck_ = false;  // The last tick moved nothing though the hand asked for it.
  bool nearKnown_ = false;
  int searches_ = 0;
  int escapeRing_ = 0, escapeRay_ = -1;
  CutLaw law_;
  double settleS_ = 0;
  bool missed_ = false;
  bool giving_ = false;  // An overlap within the tolerance is given back in this step.
};

}  // namespace argil::haptics
