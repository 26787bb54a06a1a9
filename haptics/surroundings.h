#pragma once
// All that a ball can touch in a scene, as one.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "haptics/scene.h"
#include "haptics/touchable.h"
#include "haptics/touchable_part.h"

namespace argil::haptics {

/// Nearest point of anything, and of what.
struct Around : Nearest {
  int thing = -1;                ///< Index, or -1. The same from scene to scene.
};

/// The touchables of the scene that is read now: pieces of clay first. Each keeps where its surface was last time, so a search
/// asks only those that can be near. One thread, the servo's; everything is allocated with it.
class Surroundings {
 public:
  /// Reads `scene` from now on; the caller holds it. `withClay` false: a tool that changes clay is not held by the pieces that it works
  /// on, only by what cannot be cut. `keepOuts`: of the guides; `keepOutsChanged`: they are not what they were. True when something is not what was
  /// read before.
  bool reset(const Scene& scene, bool withClay, std::span<Touchable* const> keepOuts, bool keepOutsChanged) ARGIL_REALTIME;
  /// Forgets all.
  void clear() noexcept;

  /// Nearest point within `reachMm`; inside of anything counts as inside, the deepest first.
  Around nearest(const Vec3d& p, double reachMm) ARGIL_REALTIME;
  /// True when `p` is in clay.
  bool inside(const Vec3d& p) ARGIL_REALTIME;
  /// True when `point` still lies on the surface of that thing.
  bool holds(int thing, const Vec3d& point) ARGIL_REALTIME;
  /// Touchable::normal of that thing.
  Vec3d normal(int thing, const Vec3d& point) ARGIL_REALTIME { return things_[size_t(thing)].touchable->normal(point); }
  /// Of the finest thing, mm; a ball of clay of 1 mm voxels when there is nothing.
  [[nodiscard]] double resolutionMm() const noexcept { return resolution_; }
  /// Index into Scene::materials, at a point of that thing's surface.
  [[nodiscard]] uint32_t material(int thing, const Vec3d& point) ARGIL_REALTIME {
    return size_t(thing) < kFirstPart ? clay_[size_t(thing)].material(point) : things_[size_t(thing)].material;
  }
  /// From its own frame to the world's; valid until the next reset().
  [[nodiscard]] const Pose& pose(int thing) const noexcept { return *things_[size_t(thing)].pose; }
  /// It is there, and holds the ball.
  [[nodiscard]] bool there(int thing) const noexcept { return thing >= 0 && things_[size_t(thing)].touchable != nullptr; }
  /// Goes before clay and parts where not all can hold.
  [[nodiscard]] bool hard(int thing) const noexcept { return things_[size_t(thing)].hard; }
  [[nodiscard]] bool empty() const noexcept { return count_ == 0; }
  /// Pieces of clay that the tool works on, in the scene's order.
  [[nodiscard]] std::span<TouchableClay> workedOn() noexcept { return std::span(clay_).first(workedOn_); }

 private:
  struct Thing {
    Touchable* touchable = nullptr;
    uint32_t material = 0;
    const Pose* pose = nullptr;
    bool hard = false;
    Vec3d from = Vec3d::Zero();  // Where it was searched from last,
    double bound = -1;           // and that nothing of it was nearer; negative: nothing is known.
    Vec3d near = Vec3d::Zero();  // What was found there.
    bool nearKnown = false;
  };
  void use(size_t index, Touchable& touchable, const Pose& pose, uint32_t material, bool hard, bool changed) ARGIL_REALTIME;

  // A thing keeps its index from scene to scene: pieces from 0, then parts, then keep-outs.
  static constexpr size_t kFirstPart = kMaxPieces, kFirstKeepOut = kFirstPart + kMaxParts, kMaxThings = kFirstKeepOut + kMaxGuides;
  std::vector<TouchableClay> clay_ = std::vector<TouchableClay>(kMaxPieces);
  size_t clayCount_ = 0, workedOn_ = 0;
  std::array<TouchablePart, kMaxParts> parts_;
  std::array<Thing, kMaxThings> things_{};
  std::array<int, kMaxThings> used_{};  // Indices of those that are there.
  size_t count_ = 0, countBefore_ = 0;
  double resolution_ = 1;
  bool changed_ = false;
};

}  // namespace argil::haptics
