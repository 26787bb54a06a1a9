#pragma once

#include <chrono>
#include <condition_variable>
#include <mutex>

namespace argil::engine {

/// A std::timed_mutex that ThreadSanitizer understands: GCC 12's does not see one that was waited for.
class TimedMutex {
 public:
  void lock() {
    std::unique_lock guard(guard_);
    free_.wait(guard, [this] { return !held_; });
    held_ = true;
  }
  [[nodiscard]] bool try_lock_for(std::chrono::milliseconds most) {
    std::unique_lock guard(guard_);
    if (!free_.wait_for(guard, most, [this] { return !held_; })) return false;
    return held_ = true;
  }
  void unlock() {
    {
      const std::lock_guard guard(guard_);
      held_ = false;
    }
    free_.notify_one();
  }

 private:
  std::mutex guard_;
  std::condition_variable free_;
  bool held_ = false;
};

}  // namespace argil::engine
