#pragma once
// Long work beside the person.

#include <functional>
#include <thread>

#include "clay/base/job.h"

namespace argil::engine {

/// Runs work on a thread of its own, behind the hand and the picture but not behind every other program: at the lowest
/// priority an import of a second takes minutes where others keep the processors busy. Watch it through job(); an
/// exception that leaves the work is kept for wait(). Destroying it cancels and waits, so what the work refers to need
/// only outlive this.
class BackgroundJob {
 public:
  /// A third of the weight that threads have by default.
  static constexpr int kNice = 5;
  explicit BackgroundJob(std::function<void(Job&)> work);
  ~BackgroundJob();
  BackgroundJob(const BackgroundJob&) = delete;
  BackgroundJob& operator=(const BackgroundJob&) = delete;

  [[nodiscard]] Job& job() { return job_; }
  [[nodiscard]] bool done() const { return done_.load(std::memory_order_acquire); }
  /// Returns when the work is over; throws what it threw (Cancelled after job().cancel()), each time it is called. One
  /// thread at a time.
  void wait();

 private:
  Job job_;
  std::atomic<bool> done_{false};
  std::exception_ptr failure_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace argil::engine
