#include "plugins/runner/workers.h"

#include <algorithm>

#include "plugins/runner/futex.h"

namespace argil::plugin {

Workers::Workers(unsigned threads) {
  for (unsigned i = 1; i < threads; ++i) threads_.emplace_back([this] { loop(); });
}

void Workers::takeAll() {
  for (uint32_t from = next_.fetch_add(step_); from < count_; from = next_.fetch_add(step_))
    (*work_)(from, std::min(from + step_, count_));
}

void Workers::loop() {
  for (uint32_t seen = 0;;) {
    while (round_.load() == seen) sleepWhile(round_, seen, -1);
    seen = round_.load();
    takeAll();
    if (busy_.fetch_sub(1) == 1) wakeAll(busy_);
  }
}

void Workers::run(uint32_t count, uint32_t atLeast, const std::function<void(uint32_t, uint32_t)>& work) {
  const auto threads = static_cast<uint32_t>(threads_.size()) + 1;
  if (threads == 1 || count < 2 * atLeast) {
    for (uint32_t from = 0; from < count; from += atLeast) work(from, std::min(from + atLeast, count));
    return;
  }
  work_ = &work;
  count_ = count;
  // A few ranges a thread, so that one that was held up keeps nobody waiting.
  step_ = std::max(atLeast, (count + 4 * threads - 1) / (4 * threads));
  next_.store(0);
  busy_.store(threads - 1);
  round_.fetch_add(1);
  wakeAll(round_);
  takeAll();
  for (uint32_t left = busy_.load(); left > 0; left = busy_.load()) sleepWhile(busy_, left, -1);
}

}  // namespace argil::plugin
