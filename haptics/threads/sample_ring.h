#pragma once
// Hand-off 2 of 3: every sample of the stylus, from the servo to the edit thread.

#include <atomic>
#include <bit>
#include <cstdint>
#include <span>
#include <vector>

#include "haptics/base/pose.h"

namespace argil::haptics {

/// What happened in a tick. Bits of StylusSample::flags and of ServoTick::run's answer: the tick degrades, it never
/// fails.
enum TickFlag : uint32_t {
  kOverrun = 1u << 0,      ///< The tick began later than a whole period.
  kStale = 1u << 1,        ///< The device did not answer: force zero.
  kClamped = 1u << 2,      ///< Force cut to the sheet's peak.
  kSlewed = 1u << 3,       ///< Change of force cut to the slew limit.
  kQueueFull = 1u << 4,    ///< The sample was dropped (and counted).
  kStopped = 1u << 5,      ///< Latched stop: force zero or fading to it until reset.
  kWaiting = 1u << 6,      ///< Not started: waiting for a force in range.
  kTouching = 1u << 7,     ///< The proxy is held by clay.
  kLeaving = 1u << 8,      ///< The proxy was left inside by a new version and moves out at a bounded speed.
  kCutting = 1u << 9,      ///< Clay is to be changed at this sample's cut point.
  kNoScene = 1u << 10,     ///< Nothing published yet.
  kIncomplete = 1u << 11,  ///< A limit of the contact search was met; the nearest contacts were kept.
  /// Guides leave no place in common, with each other or with the clay: the earlier, the harder holds.
  kGuideConflict = 1u << 12,
  kWarm = 1u << 13,       ///< Force held below the peak: the motors have used up their heat budget.
  kPanning = 1u << 14,    ///< A wall of the workspace is pressed and moves it.
  kClutched = 1u << 15,   ///< The clutch is held: the hand moves, the tip stays.
  kCut = 1u << 16,        ///< The device's gate is shut: the user or the watchdog holds the force at zero.
  kReturning = 1u << 17,  ///< Force on its way back from zero after a short interruption.
};

/// One tick of a stylus. Millimetres, newtons, seconds, world frame.
struct StylusSample {
  uint64_t index = 0;  ///< Counts ticks of the servo, dropped samples included.
  double timeS = 0;    ///< When the tick began, since the servo began. Virtual time: exactly its index over the rate.
  Pose device;         ///< Where the stylus is.
  Vec3d proxy = Vec3d::Zero();
  Vec3d cutPoint = Vec3d::Zero();  ///< Centre of the ball that changes the clay; valid with kCutting.
  Vec3d forceN = Vec3d::Zero();    ///< On the hand, as commanded after safety.
  double depthMm = 0;              ///< Engaged depth of a cut, else depth of the device below the proxy.
  uint32_t planes = 0;             ///< Active ones that hold the proxy.
  float pressure = 0;              ///< 0 to 1.
  uint32_t buttons = 0;            ///< Bit a button.
  uint32_t tool = 0;               ///< Scene::Tool::id at that tick.
  uint32_t flags = 0;              ///< TickFlag.
};

/// Bounded ring: one producer that never waits, one consumer. When full the newest sample is dropped and counted.
/// Allocates in its constructor alone, and touches every page there.
template <class T>
class BoundedRing {
 public:
  /// Holds at least `minimum` items (rounded up to a power of two).
  explicit BoundedRing(size_t minimum)
      : items_(std::bit_ceil(minimum < 2 ? size_t{2} : minimum)), mask_(items_.size() - 1) {}

  /// Producer's thread. False when full: `item` is dropped. Real-time safe.
  bool push(const T& item) noexcept {
    const size_t head = head_.load(std::memory_order_relaxed);
    if (head - tail_.load(std::memory_order_acquire) > mask_) {
      dropped_.fetch_add(1, std::memory_order_relaxed);
      return false;
    }
    items_[head & mask_] = item;
    head_.store(head + 1, std::memory_order_release);
    return true;
  }

  /// Consumer's thread: moves up to out.size() of the oldest items there; their count.
  size_t pop(std::span<T> out) noexcept {
    const size_t tail = tail_.load(std::memory_order_relaxed);
    const size_t waiting = head_.load(std::memory_order_acquire) - tail;
    const size_t count = waiting < out.size() ? waiting : out.size();
    for (size_t i = 0; i < count; ++i) out[i] = items_[(tail + i) & mask_];
    tail_.store(tail + count, std::memory_order_release);
    return count;
  }

  /// Items dropped so far. Any thread.
  [[nodiscard]] uint64_t dropped() const noexcept { return dropped_.load(std::memory_order_relaxed); }
  [[nodiscard]] size_t capacity() const noexcept { return items_.size(); }
  /// Items waiting, give or take what the other side does meanwhile. Any thread.
  [[nodiscard]] size_t size() const noexcept {
    const size_t tail = tail_.load(std::memory_order_acquire);
    return head_.load(std::memory_order_acquire) - tail;
  }

 private:
  std::vector<T> items_;
  size_t mask_;
  alignas(64) std::atomic<size_t> head_{0};
  alignas(64) std::atomic<size_t> tail_{0};
  alignas(64) std::atomic<uint64_t> dropped_{0};
};

inline constexpr double kRingSeconds = 8.0;  ///< What a ring holds at the servo's rate, at least.

/// The ring of a servo at `rateHz`.
class SampleRing : public BoundedRing<StylusSample> {
 public:
  explicit SampleRing(double rateHz) : BoundedRing(static_cast<size_t>(rateHz * kRingSeconds) + 1) {}
};

}  // namespace argil::haptics
