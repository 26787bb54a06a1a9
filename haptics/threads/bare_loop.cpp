#include "haptics/threads/bare_loop.h"

#include "haptics/base/clock.h"
#include "haptics/threads/realtime_thread.h"

namespace argil::haptics {

void BareLoop::start() {
  stop();
  stop_.store(false);
  thread_ = std::thread([this] { loop(); });
}

void BareLoop::stop() {
  stop_.store(true);
  if (thread_.joinable()) thread_.join();
}

void BareLoop::loop() {
  if (realtime_) (void)becomeRealtime(priority_, false);
  const double periodNs = 1e9 / rateHz_;
  const auto origin = static_cast<double>(nowNs()) + 2e6 + 0.5 * periodNs;
  for (uint64_t i = 0; !stop_.load(std::memory_order_relaxed); ++i) {
    const auto due = static_cast<int64_t>(origin + double(i) * periodNs);
    sleepUntilNs(due);
    const int64_t late = nowNs() - due;
    lateness_.add(late);
    if (double(late) > periodNs) i += static_cast<uint64_t>(double(late) / periodNs);
  }
}

}  // namespace argil::haptics
