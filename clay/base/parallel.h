#pragma once
// Fork and join over a range of indices.

#include <atomic>
#include <cstddef>
#include <exception>
#include <mutex>
#include <thread>
#include <vector>

namespace argil::clay {

/// Calls work(begin, end) for blocks that cover [0, count), on `threads` threads (the caller is one of them), in no set
/// order. Returns when all is done; the first exception is rethrown. With one thread, or little to do, no thread is
/// made.
template <class Work>
void parallelBlocks(size_t count, int threads, const Work& work, size_t block = 256) {
  if (threads <= 1 || count <= block) {
    if (count > 0) work(size_t{0}, count);
    return;
  }
  std::atomic<size_t> next{0};
  std::exception_ptr failure;
  std::mutex failureMutex;
  const auto run = [&] {
    try {
      for (size_t begin; (begin = next.fetch_add(block)) < count;)
        work(begin, begin + block < count ? begin + block : count);
    } catch (...) {
      const std::lock_guard lock(failureMutex);
      if (!failure) failure = std::current_exception();
      next = count;
    }
  };
  std::vector<std::jthread> helpers;
  for (int i = 1; i < threads; ++i) helpers.emplace_back(run);
  run();
  helpers.clear();
  if (failure) std::rethrow_exception(failure);
}

}  // namespace argil::clay
