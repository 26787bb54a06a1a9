#include "clay/brush/wall_limit.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace argil::clay {

namespace {

constexpr double kMargin = 5;           // voxels that the ball may go before the surface is looked at again
constexpr double kStep = 1;             // voxels, of the ball on its way
constexpr double kProgress = 0.02;      // voxels: a ball that comes no nearer to its stamp stays
constexpr double kFarthestPush = 1.25;  // voxels: a wall that is suddenly nearer was no wall a step before
constexpr double kClearance = 1e-3;     // voxels, by which it is pushed too far, so that pushing ends
constexpr double kWithin = 0.02;        // voxels that it may be too near for want of room
constexpr int kPushes = 24;             // of a ball between several walls
constexpr double kFacing = 0.9;         // cosine: a place is opposite where its normal leads away from the ball
constexpr double kOpposite = -0.5;      // cosine between the normals of both sides of a wall
constexpr double kBefore = 1;           // voxels before a place that must be clay
constexpr double kLook = 0.5;           // voxels between two looks at the clay before it
constexpr double kStraight = 0.02;      // voxels that a way may leave its chord
constexpr double kBrickDiagonal = 8;    // voxels, half of it, and an edge beyond
constexpr double kAhead = 6;            // voxels of a ball's way on which a wall is told of before
constexpr double kOtherWay = 0.8;       // cosine: what lies nearer to the way to a wall is the same wall
constexpr size_t kMostAhead = 4;        // walls around a ball
constexpr int kMostLooks = 512;         // for them

// Slopes of less say nothing of a direction.
constexpr float kFlat = 0.1f;

}  // namespace

void WallLimit::gather(const Editor& clay, const Vec3d& centre, double radius) {
  places_.clear();
  gathered_ = centre;
  gatheredRadius_ = radius;
  const double reach = radius + wall_ + kMargin + kAhead;
  Sampler field(clay);
  const auto brickOf = [](double v) { return static_cast<int32_t>(std::floor(v / kBrickEdge)); };
  const Coord first{brickOf(centre.x() - reach), brickOf(centre.y() - reach), brickOf(centre.z() - reach)};
  const Coord last{brickOf(centre.x() + reach), brickOf(centre.y() + reach), brickOf(centre.z() + reach)};
  const auto crossing = [&](Coord from, float a, Coord way) {
    const float b = field.voxel(from + way);
    if ((a < 0) == (b < 0)) return;
    const Vec3d at = from.toVec3d() + way.toVec3d() * (double(a) / (double(a) - double(b)));
    if ((at - centre).squaredNorm() <= reach * reach) places_.push_back(at);
  };
  BrickValues scratch;
  // What lies within the ball is being cut, wherever it goes until the next look: of a large one a shell counts.
  const double within = radius - kMargin - kBrickDiagonal;
  for (int x = first.x; x <= last.x; ++x)
    for (int y = first.y; y <= last.y; ++y) {
      const Vec3d middle = (Coord{x, y, 0} * kBrickEdge).toVec3d() + Vec3d::Constant(3.5);
      const double aside2 = (middle - centre).head<2>().squaredNorm();
      const double skip = within > 0 && aside2 < within * within ? std::sqrt(within * within - aside2) : 0;
      const int from = skip > 0 ? static_cast<int>(std::ceil((centre.z() - skip - 3.5) / kBrickEdge)) : 1;
      const int to = skip > 0 ? static_cast<int>(std::floor((centre.z() + skip - 3.5) / kBrickEdge)) : 0;
      for (int z = first.z; z <= last.z; ++z) {
        if (z >= from && z <= to) z = to + 1;
        if (z > last.z) break;
        const Slot slot = clay.find({x, y, z});
        if (slot.isTile()) continue;  // beside the surface there are bricks
        const float* values = slot.values(scratch, clay.grid().band);
        for (int i = 0; i < kBrickVoxels; ++i) {
          if (std::abs(values[i]) > 1.5f) continue;  // an edge of a voxel from there cannot cross
          const Coord voxel = Coord{x, y, z} * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
          crossing(voxel, values[i], {1, 0, 0});
          crossing(voxel, values[i], {0, 1, 0});
          crossing(voxel, values[i], {0, 0, 1});
        }
      }
    }
}

// Anew once the ball, as it is now, may meet what was not gathered.
void WallLimit::gatherAhead(const Editor& clay, const Vec3d& ball, double radius) {
  if ((ball - gathered_).norm() + std::abs(radius - gatheredRadius_) > kMargin - kStep - kFarthestPush)
    gather(clay, ball, radius);
}

bool WallLimit::isFar(Sampler& clay, const Vec3d& place, const Vec3d& ball, double radius) const {
  const Vec3d to = place - ball;
  const double length = to.norm(), outside = length - radius;
  if (!(outside > 0)) return false;  // it is being cut: a ball that comes from outside has stopped before a far one
  const Vec3d way = to / length;
  Vec3f slope;
  (void)clay.trilinear(place, slope);
  if (!(slope.norm() > kFlat)) return false;
  const Vec3d normal = slope.cast<double>().normalized();
  if (normal.dot(way) < kFacing) return false;
  const double before = std::min(kBefore, outside / 2);
  if (clay.trilinear(place - before * way) >= 0) return false;
  for (double back = before; back < outside; back += kLook)
    if (clay.trilinear(place - back * way, slope) >= 0)
      return slope.norm() > kFlat && slope.cast<double>().normalized().dot(normal) < kOpposite;
  return true;  // all of it is clay
}

// Out of the way of the walls around it; nothing where there is no room between them, or it would have to go farther
// than a step leads.
std::optional<Vec3d> WallLimit::freed(Sampler& clay, Vec3d ball, double radius) {
  const double limit = radius + wall_;
  for (int push = 0;; ++push) {
    near_.clear();
    for (uint32_t i = 0; i < places_.size(); ++i) {
      const double away2 = (places_[i] - ball).squaredNorm();
      if (away2 < limit * limit) near_.emplace_back(away2, i);
    }
    std::sort(near_.begin(), near_.end());
    const auto found = std::find_if(near_.begin(), near_.end(),
                                    [&](const auto& each) { return isFar(clay, places_[each.second], ball, radius); });
    if (found == near_.end()) return ball;
    hindered_ = true;
    const double away = std::sqrt(found->first);
    barrier_ = (places_[found->second] - ball) / away;
    if (push == kPushes) return away >= limit - kWithin ? std::optional(ball) : std::nullopt;
    if (limit - away > kFarthestPush) return std::nullopt;
    ball -= barrier_ * (limit - away + kClearance);
  }
}

// A ball near a place that touches no clay: by the shortest way out, and on by its radius.
std::optional<Vec3d> WallLimit::outsideOf(Sampler& clay, const Vec3d& place, double radius) const {
  Vec3f slope;
  double least = radius + 2 * wall_ + 1;
  if (clay.trilinear(place, slope) < 0 && slope.norm() <= kFlat) {
    Vec3d best = Vec3d::Zero();
    for (int x = -1; x <= 1; ++x)
      for (int y = -1; y <= 1; ++y)
        for (int z = -1; z <= 1; ++z) {
          const Vec3d way = Vec3d(x, y, z).normalized();
          for (double out = kLook; out < least; out += kLook)
            if (clay.trilinear(place + out * way) >= 0) least = out, best = way;
        }
    if (best.isZero()) return std::nullopt;
    return place + (least + radius) * best;
  }
  if (slope.norm() <= kFlat) return place;  // far from all clay
  const Vec3d way = slope.cast<double>().normalized();
  for (double out = 0; out < least; out += kLook)
    if (clay.trilinear(place + out * way) >= 0) return place + (out + radius) * way;
  return std::nullopt;
}

// A tip that is pressed harder: its ball is pushed off the walls around it as it grows, and as large as it was where
// it has no room.
void WallLimit::grow(const Editor& clay, Follower& follower, double radius, std::vector<Vec3d>& way) {
  Sampler field(clay);
  while (follower.radius < radius) {
    const double grown = std::min(radius, follower.radius + kStep);
    gatherAhead(clay, follower.ball, grown);
    const std::optional<Vec3d> ball = freed(field, follower.ball, grown);
    if (!ball) return;
    if (*ball != follower.ball) way.push_back(*ball);
    follower.ball = *ball;
    follower.radius = grown;
  }
}

Vec3d WallLimit::follow(const Editor& clay, Vec3d ball, const Vec3d& target, double radius, std::vector<Vec3d>* way) {
  Sampler field(clay);
  const auto tried = [&](const Vec3d& next) {
    gatherAhead(clay, next, radius);
    return freed(field, next, radius);
  };
  while (ball != target) {
    const Vec3d to = target - ball;
    const double left = to.norm();
    barrier_.setZero();
    std::optional<Vec3d> next = tried(left <= kStep ? target : Vec3d(ball + to * (kStep / left)));
    // What is in the way is slid along.
    if (!barrier_.isZero()) {
      const Vec3d along = to - to.dot(barrier_) * barrier_;
      if (const double length = along.norm(); length > kProgress) {
        const std::optional<Vec3d> beside = tried(ball + along * std::min(1.0, kStep / length));
        if (beside && (!next || (target - *beside).squaredNorm() < (target - *next).squaredNorm())) next = beside;
      }
    }
    if (!next || (*next != target && (target - *next).norm() > left - kProgress)) break;
    ball = *next;
    if (way) way->push_back(ball);
  }
  if (ball != target) hindered_ = true;
  return ball;
}

std::vector<Stamp> WallLimit::allowed(const Editor& clay, const Stamp& stamp, size_t image) {
  if (followers_.size() <= image) followers_.resize(image + 1);
  std::optional<Follower>& follower = followers_[image];
  const double radius = stamp.largestRadius() * around_;
  hindered_ = aheadKnown_ = false;
  // A tool that was lifted comes down anew.
  const bool anew = !follower || follower->target != stamp.a;
  if (anew) {
    follower.reset();
    Sampler field(clay);
    std::optional<Vec3d> ball = outsideOf(field, stamp.a, radius);
    if (ball) {
      gather(clay, *ball, radius);
      ball = freed(field, *ball, radius);
    }
    if (!ball) return {};
    hindered_ = false;
    follower = Follower{follow(clay, *ball, stamp.a, radius, nullptr), stamp.a, radius};
  } else {
    gather(clay, follower->ball, follower->radius);
  }
  std::vector<Vec3d> way{follower->ball};
  if (follower->ball != stamp.a) hindered_ = true;  // it comes from elsewhere, wherever it gets to
  follower->radius = std::min(follower->radius, radius);
  const double before = follower->radius;
  grow(clay, *follower, radius, way);
  const bool grew = follower->radius > before;
  follower->ball = follow(clay, follower->ball, stamp.b, follower->radius, &way);
  follower->target = stamp.b;
  if (!hindered_) return {stamp};

  const double start = std::min(stamp.radius, before / around_),
               end = std::min(stamp.radiusAtEnd(), follower->radius / around_);
  std::vector<Stamp> stamps;
  const auto add = [&](size_t from, size_t to) {
    Stamp part = stamp;
    part.a = way[from];
    part.b = way[to];
    const auto at = [&](size_t i) {
      return start + (end - start) * double(i) / double(std::max<size_t>(1, way.size() - 1));
    };
    part.radius = at(from);
    part.endRadius = at(to);
    stamps.push_back(part);
  };
  for (size_t from = 0; from + 1 < way.size();) {
    size_t to = from + 1;
    const auto straight = [&](size_t last) {
      const Vec3d chord = way[last] - way[from];
      for (size_t i = from + 1; i < last; ++i)
        if ((way[i] - way[from]).cross(chord).norm() > kStraight * chord.norm()) return false;
      return true;
    };
    while (to + 1 < way.size() && straight(to + 1)) ++to;
    add(from, to);
    from = to;
  }
  if (stamps.empty() && (anew || grew)) {
    Stamp dab = stamp;
    dab.a = dab.b = way[0];
    dab.radius = dab.endRadius = std::max(start, end);
    stamps.push_back(dab);
  }
  return stamps;
}

const std::vector<WallAhead>& WallLimit::ahead(const Editor& clay) {
  if (std::exchange(aheadKnown_, true)) return ahead_;
  ahead_.clear();
  Sampler field(clay);
  for (size_t image = 0; image < followers_.size(); ++image) {
    if (!followers_[image]) continue;
    const Vec3d ball = followers_[image]->ball;
    const double radius = followers_[image]->radius, limit = radius + wall_;
    gather(clay, ball, radius);
    near_.clear();
    for (uint32_t i = 0; i < places_.size(); ++i) {
      // What is nearer is no wall: the ball was kept away from those.
      const double away2 = (places_[i] - ball).squaredNorm();
      const bool ahead = away2 < (limit + kAhead) * (limit + kAhead);
      if (ahead && away2 > (limit - kWithin) * (limit - kWithin)) near_.emplace_back(away2, i);
    }
    std::sort(near_.begin(), near_.end());
    const size_t first = ahead_.size();
    int looks = 0;
    for (const auto& [away2, i] : near_) {
      const double away = std::sqrt(away2);
      const Vec3d way = (places_[i] - ball) / away;
      const auto same = [&](const WallAhead& other) { return other.wall.dot(way) > kOtherWay; };
      if (std::any_of(ahead_.begin() + std::ptrdiff_t(first), ahead_.end(), same)) continue;
      if (++looks > kMostLooks) break;
      if (!isFar(field, places_[i], ball, radius)) continue;
      ahead_.push_back({ball + (away - limit) * way, way, image});
      if (ahead_.size() - first == kMostAhead) break;
    }
  }
  return ahead_;
}

}  // namespace argil::clay
