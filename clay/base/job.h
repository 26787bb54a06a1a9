#pragma once
// Progress and cancel of a piece of long work.

#include <atomic>

#include "clay/base/error.h"

namespace argil {

/// Thrown by Job::step() once the job was cancelled. The work that it leaves must leave no trace.
class Cancelled : public Error {
 public:
  Cancelled() : Error("cancelled", Kind::work) {}
};

/// Shared by the thread that works and the one that watches; every member may be called from any thread.
/// Cost: one relaxed atomic access.
class Job {
 public:
  /// The worker reports how much is done, 0 to 1, and leaves by an exception if it was cancelled.
  void step(double fraction) {
    fraction_.store(fraction, std::memory_order_relaxed);
    if (cancelled()) throw Cancelled();
  }
  void cancel() noexcept { cancelled_.store(true, std::memory_order_relaxed); }
  [[nodiscard]] bool cancelled() const noexcept { return cancelled_.load(std::memory_order_relaxed); }
  [[nodiscard]] double fraction() const noexcept { return fraction_.load(std::memory_order_relaxed); }

 private:
  std::atomic<double> fraction_{0};
  std::atomic<bool> cancelled_{false};
};

}  // namespace argil
