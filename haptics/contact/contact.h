#pragma once
// What turns a hand's place into a force: the doors of every way of rendering contact.

#include <array>
#include <cstdint>
#include <memory>
#include <span>
#include <string_view>

#include "haptics/base/realtime.h"
#include "haptics/scene/scene.h"

namespace argil::haptics {

/// What the hand does to a piece or a part that it touches: for whoever moves that thing, to be added to the other
/// forces on it.
struct Reaction {
  int piece = -1;                   ///< Index into Scene::pieces, or -1;
  int part = -1;                    ///< into Scene::parts, or -1.
  Vec3d forceN = Vec3d::Zero();     ///< On the thing, world directions: minus its share of the force on the hand.
  Vec3d torqueNmm = Vec3d::Zero();  ///< The same force's, about `centreMm`.
  /// Of the thing, as it is felt: of a part the middle of its bounding box, of a piece the origin of its frame.
  Vec3d centreMm = Vec3d::Zero();
};
inline constexpr size_t kMaxReactions = 3;

/// One way of feeling a scene. All memory is its own from the beginning. One thread, the servo's.
class Contact {
 public:
  struct Input {
    Vec3d hand = Vec3d::Zero();      ///< Device position in the world, mm; finite.
    Vec3d velocity = Vec3d::Zero();  ///< Its filtered velocity, mm/s.
    double periodS = 1e-3;
    double topStiffnessNmm = 1;  ///< The device's limits, from its sheet.
    double topDampingNsmm = 0;   ///< The largest drag that it renders.
    double dampingNsmm = 0;      ///< Along the normal of a touched surface.
    double peakForceN = 3;
    bool pointing = false;     ///< DeviceSheet::pointing.
    bool operate = false;      ///< The tool's operation is on.
    uint32_t buttons = 0;      ///< Bit a button, for guides that work while one is down.
    uint64_t sampleIndex = 0;  ///< Of this tick.
  };
  struct Output {
    Vec3d proxy = Vec3d::Zero();  ///< Centre of the ball as the scene holds it, world mm.
    Vec3d cutPoint = Vec3d::Zero();
    Vec3d force = Vec3d::Zero();    ///< On the hand, N, world directions; no longer than the peak.
    Vec3d ambient = Vec3d::Zero();  ///< The part of `force` that no spring to the proxy gives: wells, gravity.
    bool active = false;            ///< What holds the ball moves by itself: its work is not the hand's.
    double depthMm = 0;
    double areaMm2 = 0;  ///< Engaged area while cutting.
    int planes = 0;      ///< Active planes.
    uint32_t flags = 0;  ///< TickFlag: kTouching, kLeaving, kCutting, kClamped, kIncomplete.
    std::array<Reaction, kMaxReactions>
        reactions{};        ///< While touching, not while cutting or laying: one a thing. Without guides
    int reactionCount = 0;  ///< they add up to minus `force`.
  };

  virtual ~Contact() = default;
  Contact() = default;
  Contact(const Contact&) = delete;
  Contact& operator=(const Contact&) = delete;

  /// Forgets everything: the next tick begins with the proxy at the hand.
  virtual void reset() noexcept = 0;
  virtual Output tick(const Scene& scene, const Input& input) ARGIL_REALTIME = 0;
};

/// "proxy" is what Argil uses, the others are there to compare with. Throws Error that lists them for another name.
[[nodiscard]] std::unique_ptr<Contact> makeContact(std::string_view name);
[[nodiscard]] std::span<const std::string_view> contactNames() noexcept;

}  // namespace argil::haptics
