#pragma once
// Threads of argil-plugin that divide the bricks of a stamp among them.

#include <atomic>
#include <cstdint>
#include <functional>
#include <thread>
#include <vector>

namespace argil::plugin {

class Workers {
 public:
  /// `threads` in all, the one that calls run() among them.
  explicit Workers(unsigned threads);
  /// Never: the process ends with them.
  ~Workers() = delete;

  /// Calls `work(from, to)` for ranges that make up 0 to `count`, `atLeast` long but for the last, and returns when all
  /// are done. One thread calls it.
  void run(uint32_t count, uint32_t atLeast, const std::function<void(uint32_t, uint32_t)>& work);

 private:
  void loop();
  void takeAll();

  std::vector<std::thread> threads_;
  const std::function<void(uint32_t, uint32_t)>* work_ = nullptr;
  uint32_t count_ = 0, step_ = 0;
  std::atomic<uint32_t> next_{0};
  std::atomic<uint32_t> round_{0}, busy_{0};  // futex words
};

}  // namespace argil::plugin
