#pragma once
// All that a ball can touch in a scene, as one.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "haptics/scene/scene.h"
#include "haptics/scene/touchable.h"
#include "haptics/scene/touchable_part.h"

namespace argil::haptics {

/// Nearest point of anything, and of what.
struct Around : Nearest {
  int thing = -1;  ///< Index, or -1. The same from scene to scene.
};

/// The touchables of the scene that is read now: pieces of clay first. Each keeps where its surface was last time, so a
/// search asks only those that can be near. One thread, the servo's; everything is allocated with it.
class Surroundings {
 public:
  /// Reads `scene` from now on, a tick of `periodS` after the last; the caller holds it. `withClay` false: a tool that
  /// changes clay is not held by the pieces that it works on, only by what cannot be cut. `keepOuts`: of the guides;
  /// `keepOutsChanged`: they are not what they were. True when something is not what was read before, or jumped; what
  /// only moves does so in advance().
  bool reset(const Scene& scene, bool withClay, std::span<Touchable* const> keepOuts, bool keepOutsChanged,
             double periodS) ARGIL_REALTIME;
  /// Forgets all.
  void clear() noexcept;

  // Pieces and parts that the scene has somewhere else than before go there as rigid bodies, part by part, so that
  // nothing on the way is passed by. One that is published again and again arrives when the next pose is expected; the
  // first pose after a rest of kRestS may as well be a jump (an undo): then it pushes what it touches as gently as clay
  // that grows, and what is left after kRestS is jumped over. Method: parts.md, "Moving things".

  static constexpr double kRestS = 0.25;
  /// Some thing is not yet where the scene has it.
  [[nodiscard]] bool moving() const noexcept { return movingCount_ > 0; }
  /// Decides how far each of them goes in this tick: `touching` things that may have jumped so far that a place fixed
  /// to them at `p` goes `gentleMm` at most.
  void startMotion(const Vec3d& p, std::span<const int> touching, double gentleMm) ARGIL_REALTIME;
  /// The longest way, mm, that `p` makes as seen from any of them, from one part of the tick's motion to another (0 to
  /// 1).
  [[nodiscard]] double way(const Vec3d& p, double from, double to) const ARGIL_REALTIME;
  /// All of them go to that part of the tick's motion, forwards or back.
  void advance(double part) ARGIL_REALTIME;
  /// A thing that may have jumped goes no farther in this tick.
  void holdIfGentle(int thing) ARGIL_REALTIME;
  /// After the last advance() of a tick.
  void endMotion() ARGIL_REALTIME;
  /// Where a place, and a direction, went that is fixed to a thing, in the last advance(); where it was when the thing
  /// does not move.
  [[nodiscard]] Vec3d carriedBy(int thing, const Vec3d& place) const ARGIL_REALTIME;
  [[nodiscard]] Vec3d turnedBy(int thing, const Vec3d& direction) const ARGIL_REALTIME;
  /// It went somewhere in the last advance().
  [[nodiscard]] bool moves(int thing) const noexcept {
    return size_t(thing) < kFirstKeepOut && motions_[size_t(thing)].moving;
  }

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
  /// From its own frame to the world's, as it is felt; valid until the next reset().
  [[nodiscard]] const Pose& pose(int thing) const noexcept { return *things_[size_t(thing)].pose; }
  /// Index into Scene::pieces, or into Scene::parts; -1 for what is none.
  [[nodiscard]] static int pieceOf(int thing) noexcept { return thing >= 0 && size_t(thing) < kFirstPart ? thing : -1; }
  [[nodiscard]] static int partOf(int thing) noexcept {
    return size_t(thing) >= kFirstPart && size_t(thing) < kFirstKeepOut ? thing - int(kFirstPart) : -1;
  }
  /// It is there, and holds the ball.
  [[nodiscard]] bool there(int thing) const noexcept {
    return thing >= 0 && things_[size_t(thing)].touchable != nullptr;
  }
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
  struct Motion {
    Pose at, to;          // Where it is felt, where the scene has it;
    Pose before;          // felt before the last advance();
    Pose start, goal;     // of this tick.
    double leftS = 0;     // Until it is to arrive.
    double sinceS = 1e9;  // Since the scene had it somewhere else.
    bool known = false, moving = false;
    bool gentle = false;  // It may have jumped.
  };
  void use(size_t index, Touchable& touchable, const Pose& pose, uint32_t material, bool hard,
           bool changed) ARGIL_REALTIME;
  bool follow(Motion& motion, const Pose& to, bool same) const ARGIL_REALTIME;
  void felt(size_t index, const Pose& at) ARGIL_REALTIME;

  // A thing keeps its index from scene to scene: pieces from 0, then parts, then keep-outs.
  static constexpr size_t kFirstPart = kMaxPieces, kFirstKeepOut = kFirstPart + kMaxParts,
                          kMaxThings = kFirstKeepOut + kMaxGuides;
  std::vector<TouchableClay> clay_ = std::vector<TouchableClay>(kMaxPieces);
  size_t clayCount_ = 0, workedOn_ = 0;
  std::array<TouchablePart, kMaxParts> parts_;
  std::array<Motion, kFirstKeepOut> motions_{};
  std::array<int, kFirstKeepOut> moving_{};  // Indices of those on their way.
  size_t movingCount_ = 0;
  double periodS_ = 1e-3;
  std::array<Thing, kMaxThings> things_{};
  std::array<int, kMaxThings> used_{};  // Indices of those that are there.
  size_t count_ = 0, countBefore_ = 0;
  double resolution_ = 1;
  bool changed_ = false;
};

}  // namespace argil::haptics
