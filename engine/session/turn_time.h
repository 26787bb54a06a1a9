#pragma once
// How long whoever edits the clay goes on before he shows what he did.

#include <algorithm>
#include <cstdint>

namespace argil::engine {

/// Steps (stamps, mostly) of one turn after the other. A turn is over once its budget is spent, and before a step that
/// would likely make it longer than two and a half: one stamp of a large tip takes longer than a budget. Times in ns.
class TurnTime {
 public:
  /// 0: no turn is over.
  explicit TurnTime(int64_t budget) : budget_(budget) {}
  void begin(int64_t now) { begin_ = last_ = now; }
  void step(int64_t now) {
    longest_ = std::max(now - last_, longest_ - longest_ / 4);  // Tools' steps differ, and come again.
    last_ = now;
  }
  [[nodiscard]] bool over() const {
    const int64_t spent = last_ - begin_;
    if (budget_ <= 0) return false;
    return spent >= budget_ || (spent >= budget_ / kWorthShowing && spent + longest_ > budget_ * 5 / 2);
  }

 private:
  static constexpr int64_t kWorthShowing = 4;  // of a budget: less is not shown by itself
  int64_t budget_, begin_ = 0, last_ = 0, longest_ = 0;
};

}  // namespace argil::engine
