#pragma once
// Several threads' code in one thread, in an order that a seed decides: every step() is a place where another may go
// on.

#include <ucontext.h>

#include <cstdint>
#include <exception>
#include <functional>
#include <memory>
#include <random>
#include <vector>

namespace argil::testing {

/// Bodies run as fibers with stacks of their own, so that real code is suspended wherever it calls step(), however
/// deep. The same seed gives the same order. Not under ThreadSanitizer, which knows of no fibers. One at a time.
class Interleaver {
 public:
  /// At a step another goes on with this probability.
  Interleaver(uint64_t seed, double switching) : random_(seed), switching_(switching) {}
  Interleaver(const Interleaver&) = delete;
  Interleaver& operator=(const Interleaver&) = delete;

  void add(std::function<void()> body) { bodies_.push_back(std::move(body)); }

  /// Until all have ended.
  void run() {
    current() = this;
    fibers_.resize(bodies_.size());
    alive_.clear();
    for (size_t i = 0; i < bodies_.size(); ++i) {
      getcontext(&fibers_[i]);
      fibers_[i].uc_stack.ss_sp = stack(i);
      fibers_[i].uc_stack.ss_size = kStack;
      fibers_[i].uc_link = &main_;
      makecontext(&fibers_[i], &Interleaver::enter, 0);
      alive_.push_back(i);
    }
    while (!alive_.empty()) {
      running_ = alive_[random_() % alive_.size()];
      swapcontext(&main_, &fibers_[running_]);
      if (ended_) std::erase(alive_, running_);  // The one that was running last.
      ended_ = false;
    }
    current() = nullptr;
    if (failure_) std::rethrow_exception(failure_);
  }

  /// Nothing outside of run().
  static void step() {
    if (Interleaver* self = current()) self->yield();
  }
  [[nodiscard]] uint64_t switches() const { return switches_; }

 private:
  static constexpr size_t kStack = 256 * 1024;

  static Interleaver*& current() {
    static Interleaver* one = nullptr;
    return one;
  }
  static char* stack(size_t index) {
    static std::vector<std::unique_ptr<char[]>> stacks;
    while (stacks.size() <= index) stacks.push_back(std::make_unique<char[]>(kStack));
    return stacks[index].get();
  }
  static void enter() {
    Interleaver& self = *current();
    try {
      self.bodies_[self.running_]();
    } catch (...) {
      if (!self.failure_) self.failure_ = std::current_exception();
    }
    self.ended_ = true;
  }
  void yield() {
    if (std::uniform_real_distribution<double>()(random_) >= switching_) return;
    const size_t next = alive_[random_() % alive_.size()];
    if (next == running_) return;
    const size_t self = running_;
    running_ = next;
    ++switches_;
    swapcontext(&fibers_[self], &fibers_[next]);
  }

  std::mt19937_64 random_;
  double switching_;
  std::vector<std::function<void()>> bodies_;
  std::vector<ucontext_t> fibers_;
  std::vector<size_t> alive_;
  ucontext_t main_{};
  size_t running_ = 0;
  uint64_t switches_ = 0;
  bool ended_ = false;
  std::exception_ptr failure_;
};

}  // namespace argil::testing
