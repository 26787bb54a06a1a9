#pragma once
// Who holds the force of a device at zero: one word that every thread can read and change in one step.

#include <atomic>
#include <cstdint>

#include "haptics/base/realtime.h"

namespace argil::haptics {

/// Whoever may stop a force. Each owner undoes its own stops alone.
enum class StopOwner : uint8_t {
  user,      ///< A person, through Workbench::stopForces().
  watchdog,  ///< The servo's watchdog: no tick ended for kWatchdogSeconds.
  device,    ///< The device's own thread: it came so late that somebody else may have zeroed the motors meanwhile.
};

/// The gate between every command of force and the motor. The word holds one counter of 16 bits for each owner; an odd
/// counter means that this owner holds the force at zero. Invariant: after stop() returned, open() is false until the
/// same owner's resume() that names this stop or a later one. Each function is one atomic step (sequentially
/// consistent, lock-free), so every order of the threads is an order of these steps;
/// tests/unit/engine/forces_interleaved_test.cpp tries them. Any thread, the servo's included.
class ForceGate {
 public:
  /// Equal words, read one after the other: nobody stopped or resumed in between.
  using Word = uint64_t;
  /// Which of an owner's stops (and resumes) the reader has seen. After 32768 stops a generation comes again: no resume
  /// waits so long.
  using Generation = uint16_t;

  [[nodiscard]] Word word() const noexcept { return word_.load(); }
  /// Nobody holds the force at zero.
  [[nodiscard]] static bool open(Word word) noexcept { return (word & kAnyStop) == 0; }
  [[nodiscard]] bool open() const noexcept { return open(word()); }
  [[nodiscard]] static bool stoppedBy(StopOwner owner, Word word) noexcept { return (of(word, owner) & 1) != 0; }
  /// An owner stopped or resumed between two words.
  [[nodiscard]] static bool changed(StopOwner owner, Word a, Word b) noexcept { return of(a, owner) != of(b, owner); }
  [[nodiscard]] bool stoppedBy(StopOwner owner) const noexcept { return stoppedBy(owner, word()); }
  [[nodiscard]] Generation generation(StopOwner owner) const noexcept { return of(word(), owner); }

  /// Zero force from now on; returns the generation that a resume must name.
  Generation stop(StopOwner owner) noexcept {
    return change(owner, [](Generation now) { return static_cast<Generation>(now + (now & 1 ? 2 : 1)); });
  }
  /// Ends this owner's stops that its caller had seen: those up to generation `seen`. False, and nothing changes, when
  /// the owner stopped or resumed since then. True also when this owner had stopped nothing.
  bool resume(StopOwner owner, Generation seen) noexcept {
    bool named = false;
    change(owner, [&](Generation now) {
      named = now == seen;
      return static_cast<Generation>(named ? now + (now & 1) : now);
    });
    return named;
  }
  /// A stop and its resume as one step: commands of before are void, and a stop in force stays in force.
  void interrupt(StopOwner owner) noexcept {
    change(owner, [](Generation now) { return static_cast<Generation>(now + 2); });
  }

 private:
  static constexpr int kBits = 16;
  static constexpr Word kAnyStop = 0x0001'0001'0001'0001;

  static Generation of(Word word, StopOwner owner) noexcept {
    return static_cast<Generation>(word >> (kBits * static_cast<int>(owner)));
  }
  template <class Next>
  Generation change(StopOwner owner, Next next) noexcept {
    const int shift = kBits * static_cast<int>(owner);
    Word before = word_.load();
    for (;;) {
      const Generation made = next(of(before, owner));
      const Word after = (before & ~(Word{0xffff} << shift)) | (Word{made} << shift);
      if (word_.compare_exchange_weak(before, after)) return made;
    }
  }

  std::atomic<Word> word_{0};
};

}  // namespace argil::haptics
