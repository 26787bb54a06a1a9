#pragma once
// Which bricks of a stroke wait to be redistanced. This module's own.

#include <cstdint>
#include <deque>
#include <unordered_map>
#include <utility>
#include <vector>

#include "clay/field/redistance.h"
#include "clay/store/brick_set.h"

namespace argil::clay {

/// Redistancing trails the tool: a brick is due some stamps after the last one that touched it. What is due follows
/// from the stamps alone. Stamps are counted from 1.
class Trail {
 public:
  /// `mostDrift`: a brick whose distances may have changed by more since they were solved is solved at once.
  explicit Trail(float mostDrift = 1) : mostDrift_(mostDrift) {}
  /// Stamp number `stamp` came near these bricks, in any order: all that it wrote, and those beside them.
  void touch(uint64_t stamp, std::vector<Coord> bricks);
  /// Distances of a brick were changed by `change` voxels at most since it was solved, in a way that calls for `renew`.
  /// Whether it should be solved at once.
  bool change(Coord brick, float change, Renew renew);
  /// Whether a brick was touched and not redistanced since.
  [[nodiscard]] bool waits(Coord brick) const;

  /// Bricks that no stamp after `stamp` touched are due from now on.
  void follow(uint64_t stamp);
  [[nodiscard]] size_t due() const { return due_.size(); }

  /// What one call of redistance() gets: bricks, sorted, and how each is renewed.
  struct Work {
    std::vector<Coord> bricks;
    std::vector<Renew> renew;
  };
  /// The first `most` that are due, and neighbours that were solved before, because they met values of these that were
  /// only a bound. Those that still trail need not be, for they will be solved against what is solved now.
  [[nodiscard]] Work take(size_t most);
  /// These and those beside them, whether they are due or not.
  [[nodiscard]] Work takeNow(const std::vector<Coord>& bricks);

 private:
  static constexpr uint64_t kDone = 0;
  struct Touched {
    uint64_t stamp = kDone;  // the last; kDone once it was redistanced
    float drift = 0;         // how much its distances may have changed since
    Renew renew = Renew::none;
  };
  [[nodiscard]] Work workOn(std::vector<Coord> bricks);

  float mostDrift_;
  std::unordered_map<Coord, Touched, CoordHash> touched_;
  std::deque<std::pair<uint64_t, std::vector<Coord>>> stamps_;
  std::vector<Coord> due_;
};

}  // namespace argil::clay
