#include "io/bytes/byte_sink.h"

#include <condition_variable>
#include <exception>
#include <mutex>
#include <thread>
#include <utility>

namespace argil::io {

/// Writes one piece while the next is filled.
class ByteSink::Writer {
 public:
  explicit Writer(AtomicFile& file)
      : file_(file), piece_(kSize), thread_([this](const std::stop_token& stop) { run(stop); }) {}

  /// Swaps in a piece that may be filled. Throws what writing an earlier one threw.
  void take(std::vector<std::byte>& piece, size_t size) {
    std::unique_lock lock(mutex_);
    waitUntilIdle(lock);
    std::swap(piece_, piece);
    size_ = size;
    lock.unlock();
    changed_.notify_all();
  }
  void wait() {
    std::unique_lock lock(mutex_);
    waitUntilIdle(lock);
  }

 private:
  void waitUntilIdle(std::unique_lock<std::mutex>& lock) {
    changed_.wait(lock, [&] { return size_ == 0; });
    if (failure_) std::rethrow_exception(failure_);
  }

  void run(const std::stop_token& stop) {
    std::unique_lock lock(mutex_);
    while (changed_.wait(lock, stop, [&] { return size_ != 0; })) {
      lock.unlock();
      std::exception_ptr failure;
      try {
        file_.write({piece_.data(), size_});
      } catch (...) {
        failure = std::current_exception();
      }
      lock.lock();
      size_ = 0;
      failure_ = failure;
      changed_.notify_all();
    }
  }

  AtomicFile& file_;
  std::mutex mutex_;
  std::condition_variable_any changed_;
  std::vector<std::byte> piece_;  // The thread's while size_ is not 0.
  size_t size_ = 0;
  std::exception_ptr failure_;
  std::jthread thread_;  // Last: it uses all of these.
};

ByteSink::ByteSink(AtomicFile& file) : file_(file), buffer_(kSize) {}
ByteSink::~ByteSink() = default;

void ByteSink::handOver() {
  if (!writer_) writer_ = std::make_unique<Writer>(file_);
  writer_->take(buffer_, used_);
  used_ = 0;
}

void ByteSink::putLarge(const void* bytes, size_t size) {
  flush();
  file_.write({static_cast<const std::byte*>(bytes), size});
}

void ByteSink::flush() {
  if (writer_) writer_->wait();
  file_.write({buffer_.data(), used_});
  used_ = 0;
}

}  // namespace argil::io
