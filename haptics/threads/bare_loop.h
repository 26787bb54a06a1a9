#pragma once
// The peer of the servo's lateness: a thread that only sleeps.

#include <atomic>
#include <thread>

#include "haptics/base/histogram.h"

namespace argil::haptics {

/// clock_nanosleep on absolute time at the servo's rate and priority, half a period out of phase, doing nothing else:
/// how late this machine wakes anybody. Runs beside a servo, in the same seconds.
class BareLoop {
 public:
  explicit BareLoop(double rateHz, bool realtime = true, int priority = 80)
      : rateHz_(rateHz), realtime_(realtime), priority_(priority) {}
  ~BareLoop() { stop(); }
  BareLoop(const BareLoop&) = delete;
  BareLoop& operator=(const BareLoop&) = delete;

  void start();
  void stop();
  /// After stop().
  [[nodiscard]] const Histogram& lateness() const noexcept { return lateness_; }

 private:
  void loop();
  double rateHz_;
  bool realtime_;
  int priority_;
  Histogram lateness_;
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

}  // namespace argil::haptics
