#pragma once
// Long work that stops at places of its own choice, so that whoever asked for it can do something else between.

#include <coroutine>
#include <exception>
#include <utility>

namespace argil::clay {

/// A coroutine: the function that returns it runs on next() alone, as far as its next `co_yield Steps::kPause`. One
/// thread at a time. References among its arguments have to outlive it. Destroyed before its end: it stays where it
/// was, and what it holds is given back.
class Steps {
 public:
  struct Pause {};
  static constexpr Pause kPause{};

  struct promise_type {
    std::exception_ptr failure;
    Steps get_return_object() { return Steps(std::coroutine_handle<promise_type>::from_promise(*this)); }
    std::suspend_always initial_suspend() noexcept { return {}; }
    std::suspend_always final_suspend() noexcept { return {}; }
    std::suspend_always yield_value(Pause) noexcept { return {}; }
    void return_void() noexcept {}
    void unhandled_exception() noexcept { failure = std::current_exception(); }
  };

  Steps(Steps&& other) noexcept : at_(std::exchange(other.at_, nullptr)) {}
  ~Steps() {
    if (at_) at_.destroy();
  }

  /// Goes on. False once the end is reached; then it is not asked again. Throws what the function threw, which ends it.
  [[nodiscard]] bool next() {
    at_.resume();
    if (!at_.done()) return true;
    if (const std::exception_ptr failure = std::exchange(at_.promise().failure, nullptr))
      std::rethrow_exception(failure);
    return false;
  }
  /// All that is left, at once.
  void finish() {
    while (next()) {
    }
  }

 private:
  explicit Steps(std::coroutine_handle<promise_type> at) : at_(at) {}
  std::coroutine_handle<promise_type> at_;
};

}  // namespace argil::clay
