#pragma once
// Cancelling of work that is not handed a job.

#include <utility>

#include "clay/base/job.h"

namespace argil::clay {

/// While it lives, Surface::update() of this thread asks the job after each region and throws Cancelled; the surface
/// then starts anew at its next update. The job must outlive it. Scopes may be nested.
class JobScope {
 public:
  explicit JobScope(const Job* job) : before_(std::exchange(current_, job)) {}
  ~JobScope() { current_ = before_; }
  JobScope(const JobScope&) = delete;
  JobScope& operator=(const JobScope&) = delete;

  /// Returns the job of this thread's scope; null where there is none.
  [[nodiscard]] static const Job* current() { return current_; }

 private:
  inline static thread_local const Job* current_ = nullptr;
  const Job* before_;
};

}  // namespace argil::clay
