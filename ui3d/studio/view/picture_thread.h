#pragma once
// The thread that draws, so that the window's own is free for the hand.

#include <condition_variable>
#include <exception>
#include <functional>
#include <mutex>
#include <thread>

namespace argil::studio {

/// Runs one piece of work at a time. run(), take() and busy() are for one thread.
class PictureThread {
 public:
  /// `done` is called on the thread after each piece of work.
  explicit PictureThread(std::function<void()> done);
  /// Waits for the work that runs.
  ~PictureThread();
  PictureThread(const PictureThread&) = delete;
  PictureThread& operator=(const PictureThread&) = delete;

  /// From run() until take() has returned true.
  [[nodiscard]] bool busy() const { return given_; }
  /// Not while busy.
  void run(std::function<void()> work);
  /// True once the work is over; throws what it threw.
  bool take();
  /// take() that waits; at once when nothing runs.
  void finish();

 private:
  void loop();

  std::function<void()> done_;
  std::mutex mutex_;
  std::condition_variable wake_, over_;
  std::function<void()> work_;  // Empty: nothing to do.
  std::exception_ptr failure_;
  bool finished_ = true, quit_ = false;
  bool given_ = false;
  std::thread thread_;  // Last: it uses the others.
};

}  // namespace argil::studio
