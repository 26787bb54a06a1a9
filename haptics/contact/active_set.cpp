#include "haptics/contact/active_set.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace argil::haptics {
namespace {

// Offsets relative to the goal are compared to this part of the largest of them: rounding of a 3×3 solve.
constexpr double kRelativeTolerance = 1e-10;
// Two planes closer than this (sine squared of the angle) are one.
constexpr double kParallel = 1e-14;
// A plane whose normal leans less than this (sine) into a locked set can only be met or not met as a whole,
constexpr double kAcross = 1e-9;
// and is met up to rounding of places some metres away, mm.
constexpr double kMet = 1e-9;

struct Candidate {
  Vec3d step;
  std::array<int, 3> active;
  std::array<double, 3> multiplier;
  int count;
};

class Search {
 public:
  Search(const Vec3d& goal, const HalfSpace* planes, int count) noexcept : planes_(planes), count_(count) {
    for (int i = 0; i < count; ++i) {
      wanted_[size_t(i)] = planes[i].offset - planes[i].normal.dot(goal);
      scale_ = std::max(scale_, std::abs(wanted_[size_t(i)]));
    }
    tolerance_ = kRelativeTolerance * scale_;
  }
  double wanted(int i) const noexcept { return wanted_[size_t(i)]; }

  /// Whether planes may push that hard; asked before a candidate is made, for most are refused here.
  bool pushes(double multiplier) const noexcept { return multiplier >= -tolerance_; }

  void consider(const Candidate& c) noexcept {
    const double bound = std::max(best_, tolerance_);
    double violation = 0;
    for (int i = 0; i < count_; ++i) {
      violation = std::max(violation, wanted(i) - planes_[i].normal.dot(c.step));
      if (violation > bound) return;
    }
    // Among candidates that are as good as feasible the shortest step is the nearest point.
    if (violation <= tolerance_) violation = 0;
    if (violation < best_ || (violation == best_ && c.step.squaredNorm() < chosen_.step.squaredNorm())) {
      best_ = violation;
      chosen_ = c;
    }
  }
  double tolerance() const noexcept { return tolerance_; }
  double best() const noexcept { return best_; }
  double scale() const noexcept { return scale_; }
  const Candidate& chosen() const noexcept { return chosen_; }

 private:
  const HalfSpace* planes_;
  int count_;
  std::array<double, kMaxHalfSpaces> wanted_{};
  double scale_ = 0, tolerance_ = 0;
  double best_ = std::numeric_limits<double>::infinity();
  Candidate chosen_{Vec3d::Zero(), {}, {}, 0};
};

ActiveSet solveWithin(const Vec3d& foot, const HalfSpace* planes, int count, const Subspace& within) noexcept {
  ActiveSet result;
  result.x = foot;
  // Seen from within, each plane is one whose unit normal lies along the set: the free solve then never leaves it.
  std::array<HalfSpace, kMaxHalfSpaces> seen;
  std::array<int, kMaxHalfSpaces> index{};
  std::array<double, kMaxHalfSpaces> lean{};
  int used = 0;
  for (int i = 0; i < count; ++i) {
    const Vec3d along = within.along(planes[i].normal);
    const double lack = planes[i].offset - planes[i].normal.dot(foot), sine = along.norm();
    if (!(sine > kAcross)) {
      if (lack > kMet) result.feasible = false;
      continue;
    }
    const Vec3d normal = along / sine;
    seen[size_t(used)] = {normal, normal.dot(foot) + lack / sine};
    lean[size_t(used)] = sine;
    index[size_t(used++)] = i;
  }
  if (!result.feasible) return result;
  const ActiveSet solved = nearestAllowed(foot, seen.data(), used);
  result.feasible = solved.feasible;
  if (!solved.feasible) return result;
  result.x = within.nearest(solved.x);
  result.count = solved.count;
  for (int i = 0; i < solved.count; ++i) {
    const size_t s = size_t(solved.active[size_t(i)]);
    result.active[size_t(i)] = index[s];
    result.multiplier[size_t(i)] = solved.multiplier[size_t(i)] / lean[s];
  }
  return result;
}

}  // namespace

ActiveSet nearestAllowed(const Vec3d& goal, const HalfSpace* planes, int count) ARGIL_REALTIME {
  ActiveSet result;
  result.x = goal;
  count = std::min(count, kMaxHalfSpaces);
  Search search(goal, planes, count);
  bool allowed = true;
  for (int i = 0; i < count; ++i) allowed = allowed && !(search.wanted(i) > 0);
  if (allowed) return result;

  for (int i = 0; i < count; ++i) {
    if (!(search.wanted(i) > 0)) continue;
    search.consider({search.wanted(i) * planes[i].normal, {i}, {search.wanted(i)}, 1});
  }
  for (int i = 0; i < count && search.best() > 0; ++i)
    for (int j = i + 1; j < count; ++j) {
      const double g = planes[i].normal.dot(planes[j].normal), det = 1 - g * g;
      if (det < kParallel) continue;
      const double a = (search.wanted(i) - g * search.wanted(j)) / det,
                   b = (search.wanted(j) - g * search.wanted(i)) / det;
      if (!search.pushes(a) || !search.pushes(b)) continue;
      search.consider({a * planes[i].normal + b * planes[j].normal, {i, j}, {a, b}, 2});
    }
  for (int i = 0; i < count && search.best() > 0; ++i)
    for (int j = i + 1; j < count; ++j)
      for (int k = j + 1; k < count; ++k) {
        const Vec3d &n = planes[i].normal, &m = planes[j].normal, &o = planes[k].normal;
        const Vec3d mo = m.cross(o);
        const double volume = n.dot(mo);
        if (volume * volume < kParallel) continue;
        // The corner where the three meet, and what each plane pays to hold it there.
        const Vec3d on = o.cross(n), nm = n.cross(m);
        const Vec3d step = (search.wanted(i) * mo + search.wanted(j) * on + search.wanted(k) * nm) / volume;
        const double a = step.dot(mo) / volume, b = step.dot(on) / volume, c = step.dot(nm) / volume;
        if (!search.pushes(a) || !search.pushes(b) || !search.pushes(c)) continue;
        search.consider({step, {i, j, k}, {a, b, c}, 3});
      }

  if (search.best() > 1e-6 * search.scale()) {
    result.feasible = false;
    return result;
  }
  result.x = goal + search.chosen().step;
  result.active = search.chosen().active;
  result.multiplier = search.chosen().multiplier;
  result.count = search.chosen().count;
  return result;
}

ActiveSet nearestAllowed(const Vec3d& goal, const HalfSpace* planes, int count, const Subspace& within,
                         int hard) ARGIL_REALTIME {
  count = std::min(count, kMaxHalfSpaces);
  const bool locked = within.dimension < 3;
  const Vec3d foot = within.nearest(goal);
  ActiveSet result = locked ? solveWithin(foot, planes, count, within) : nearestAllowed(goal, planes, count);
  if (result.feasible || hard <= 0 || hard >= count) return result;
  result = locked ? solveWithin(foot, planes, hard, within) : nearestAllowed(goal, planes, hard);
  result.feasible = false;
  return result;
}

}  // namespace argil::haptics
