#include "clay/brush/trail.h"

#include <algorithm>

namespace argil::clay {

void Trail::touch(uint64_t stamp, std::vector<Coord> bricks) {
  std::sort(bricks.begin(), bricks.end());
  bricks.erase(std::unique(bricks.begin(), bricks.end()), bricks.end());
  for (const Coord c : bricks) touched_[c].stamp = stamp;
  stamps_.emplace_back(stamp, std::move(bricks));
}

bool Trail::change(Coord brick, float change, Renew renew) {
  Touched& touched = touched_[brick];
  touched.drift += change;
  touched.renew = std::max(touched.renew, renew);
  return touched.drift > mostDrift_;
}

bool Trail::waits(Coord brick) const {
  const auto it = touched_.find(brick);
  return it != touched_.end() && it->second.stamp != kDone;
}

void Trail::follow(uint64_t stamp) {
  for (; !stamps_.empty() && stamps_.front().first <= stamp; stamps_.pop_front())
    for (const Coord c : stamps_.front().second)
      if (touched_[c].stamp == stamps_.front().first) due_.push_back(c);
}

Trail::Work Trail::take(size_t most) {
  const auto end = due_.begin() + static_cast<ptrdiff_t>(std::min(most, due_.size()));
  const std::vector<Coord> now(due_.begin(), end);
  due_.erase(due_.begin(), end);
  for (const Coord c : now) touched_[c].stamp = kDone;
  std::vector<Coord> all = withNeighbours(now);
  std::erase_if(all, [&](Coord c) {
    const auto it = touched_.find(c);
    return it == touched_.end() || it->second.stamp != kDone;
  });
  return workOn(std::move(all));
}

Trail::Work Trail::takeNow(const std::vector<Coord>& bricks) {
  return workOn(withNeighbours(bricks));
}

Trail::Work Trail::workOn(std::vector<Coord> bricks) {
  Work work{std::move(bricks), {}};
  work.renew.reserve(work.bricks.size());
  for (const Coord c : work.bricks) {
    Touched& touched = touched_[c];
    work.renew.push_back(touched.renew);
    touched.drift = 0;
  }
  return work;
}

}  // namespace argil::clay
