#include "ui3d/studio/view/picture_thread.h"

#include <utility>

namespace argil::studio {

PictureThread::PictureThread(std::function<void()> done) : done_(std::move(done)), thread_([this] { loop(); }) {}

PictureThread::~PictureThread() {
  {
    const std::lock_guard lock(mutex_);
    quit_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void PictureThread::run(std::function<void()> work) {
  {
    const std::lock_guard lock(mutex_);
    work_ = std::move(work);
    finished_ = false;
  }
  given_ = true;
  wake_.notify_one();
}

bool PictureThread::take() {
  if (!given_) return false;
  std::exception_ptr failure;
  {
    const std::lock_guard lock(mutex_);
    if (!finished_) return false;
    failure = std::exchange(failure_, nullptr);
  }
  given_ = false;
  if (failure) std::rethrow_exception(failure);
  return true;
}

void PictureThread::finish() {
  if (!given_) return;
  {
    std::unique_lock lock(mutex_);
    over_.wait(lock, [this] { return finished_; });
  }
  take();
}

void PictureThread::loop() {
  std::unique_lock lock(mutex_);
  while (true) {
    wake_.wait(lock, [this] { return quit_ || work_; });
    if (!work_) return;
    const std::function<void()> work = std::exchange(work_, nullptr);
    lock.unlock();
    std::exception_ptr failure;
    try {
      work();
    } catch (...) {
      failure = std::current_exception();
    }
    lock.lock();
    failure_ = failure;
    finished_ = true;
    over_.notify_all();
    lock.unlock();
    done_();
    lock.lock();
  }
}

}  // namespace argil::studio
