#include "haptics/scene/closest_surface.h"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>

#include <hwy/highway.h>

namespace argil::haptics {
namespace {

namespace hn = hwy::HWY_NAMESPACE;  // The baseline's vectors: four lanes are enough for a hundred points.

constexpr int kCandidates = 4;  // Sign changes that are walked to the closest point of their neighbourhood.
constexpr int kWalkSteps = 8;
constexpr int kRimHalvings = 7;      // Of less than two voxels.
constexpr double kOnSurface = 2e-3;  // Voxels: a point this near to the zero surface is on it.
// Voxels along the surface: the distance then errs by its square over twice itself.
constexpr double kWalkDone = 2e-3;
constexpr double kPatch2 = 1.5 * 1.5;  // Voxels²: how far a patch around a walked point reaches,
constexpr double kPatchRise = 0.02;    // and how far a point of it may rise above the tangent plane, voxels.
// A cell's own sign change is within half a diagonal of its surface, squared.
constexpr double kCellDiagonal2 = 0.75;
constexpr double kAhead = 3;  // Voxels that the bricks around are gathered for beyond what is asked,
// and that a brick is looked through beyond it: so far the next calls need not look again.
constexpr double kLook = 1;

constexpr size_t kLanes = 4;
constexpr float kFar = 1e6f;

// From p to the box of the sign changes that a brick owns, squared: its last edges end at the next brick's first
// voxels.
double gap2(Coord brick, const Vec3d& p) noexcept {
  double sum = 0;
  const double low[3] = {8.0 * brick.x, 8.0 * brick.y, 8.0 * brick.z};
  for (int a = 0; a < 3; ++a) {
    const double gap = std::max({0.0, low[a] - p[a], p[a] - low[a] - clay::kBrickEdge});
    sum += gap * gap;
  }
  return sum;
}

}  // namespace

struct ClosestSurface::Candidates {
  double best;   // Distance of the nearest point of the surface known so far.
  double best2;  // Its square with the slack that keeps neighbours of a better point in.
  std::array<float, kCandidates> distance2;
  std::array<Vec3d, kCandidates> point;
  int count = 0;

  explicit Candidates(double reach) : best(reach) { widen(); }
  void widen() noexcept {
    const double limit = std::sqrt(best * best + kCellDiagonal2) + 0.05;
    best2 = limit * limit;
  }
  void improve(double distance) noexcept {
    if (distance >= best) return;
    best = distance;
    widen();
  }
  void add(float d2, const Vec3d& at) noexcept {
    if (count == kCandidates && d2 >= distance2[kCandidates - 1]) return;
    int i = count < kCandidates ? count++ : kCandidates - 1;
    for (; i > 0 && distance2[size_t(i) - 1] > d2; --i) {
      distance2[size_t(i)] = distance2[size_t(i) - 1];
      point[size_t(i)] = point[size_t(i) - 1];
    }
    distance2[size_t(i)] = d2;
    point[size_t(i)] = at;
    if (double(d2) < best * best) improve(std::sqrt(double(d2)));
  }
};

void ClosestSurface::reset(const clay::Version& version, bool hideMasked) ARGIL_REALTIME {
  sampler_.reset(version);
  const bool hid = hides();
  hiding_ = hideMasked && version.has(clay::Channel::mask) ? &version : nullptr;
  band_ = version.grid().band;
  // Addresses of records are reused, ids are per store: both together name a version.
  if (version_ == version.record() && versionId_ == version.id() && hid == hides()) return;
  version_ = version.record();
  versionId_ = version.id();
  covered_ = -1;
  ++generation_;
}

bool ClosestSurface::hidden(Coord voxel) ARGIL_REALTIME {
  return hides() && hiding_->find(clay::Channel::mask, voxel >> 3)
                            .value(clay::Brick::offset(voxel.x & 7, voxel.y & 7, voxel.z & 7)) > 127;
}

// Calls meet(x, y, z) for each edge that the brick owns, crosses the surface and begins within `reach` of `from`;
// coordinates from the brick's corner. Sign changes along the axes are words of 64 bits.
template <class Meet>
void ClosestSurface::eachCrossing(const clay::Brick& brick, Coord coord, const Vec3f& from, float reach,
                                  Meet meet) ARGIL_REALTIME {
  using clay::Slot;
  const float step = sampler_.step();
  constexpr uint64_t kLowZ = 0x0101010101010101ull;
  const auto word = [](Slot s, int x) -> uint64_t {
    return s.isTile() ? (s.tile() == clay::Tile::inside ? ~uint64_t{0} : 0) : s.brick()->inside[x];
  };
  const Slot beyondX = sampler_.slot(coord + Coord{1, 0, 0});
  const Slot beyondY = sampler_.slot(coord + Coord{0, 1, 0});
  const Slot beyondZ = sampler_.slot(coord + Coord{0, 0, 1});
  const clay::ChannelSlot mask = hides() ? hiding_->find(clay::Channel::mask, coord) : clay::ChannelSlot();
  const bool masked = mask != clay::ChannelSlot();
  float away2[3][clay::kBrickEdge];  // To the voxels along each axis, squared.
  for (int axis = 0; axis < 3; ++axis)
    for (int i = 0; i < clay::kBrickEdge; ++i) away2[axis][i] = (float(i) - from[axis]) * (float(i) - from[axis]);

  for (int x = 0; x < clay::kBrickEdge; ++x) {
    const float left = reach * reach - away2[0][x];
    if (left < 0) continue;
    const uint64_t w = brick.inside[x];
    const uint64_t alongX = w ^ (x < 7 ? brick.inside[x + 1] : word(beyondX, 0));
    const uint64_t alongY = w ^ ((w >> 8) | (word(beyondY, x) << 56));
    const uint64_t alongZ = w ^ (((w >> 1) & ~(kLowZ << 7)) | ((word(beyondZ, x) & kLowZ) << 7));
    for (uint64_t bits = alongX | alongY | alongZ; bits; bits &= bits - 1) {
      const int bit = std::countr_zero(bits), y = bit >> 3, z = bit & 7;
      if (away2[1][y] + away2[2][z] > left || (masked && mask.value(clay::Brick::offset(x, y, z)) > 127)) continue;
      const float a = brick.phi(clay::Brick::offset(x, y, z), step);
      const auto part = [a](float b) { return a / (a - b); };
      const float fx = float(x), fy = float(y), fz = float(z);
      if ((alongX >> bit) & 1)
        meet(fx + part(x < 7 ? brick.phi(clay::Brick::offset(x + 1, y, z), step)
                             : beyondX.phi(clay::Brick::offset(0, y, z), band_, step)),
             fy, fz);
      if ((alongY >> bit) & 1)
        meet(fx,
             fy + part(y < 7 ? brick.phi(clay::Brick::offset(x, y + 1, z), step)
                             : beyondY.phi(clay::Brick::offset(x, 0, z), band_, step)),
             fz);
      if ((alongZ >> bit) & 1)
        meet(fx, fy,
             fz + part(z < 7 ? brick.phi(clay::Brick::offset(x, y, z + 1), step)
                             : beyondZ.phi(clay::Brick::offset(x, y, 0), band_, step)));
    }
  }
}

const ClosestSurface::Crossings& ClosestSurface::crossings(const clay::Brick& brick, Coord coord) ARGIL_REALTIME {
  // Neighbours along any axis fall into different sets.
  Crossings& kept =
      memory_->crossings[size_t((coord.x & 3) + 4 * (coord.y & 3) + 16 * ((coord.z ^ (coord.x >> 2)) & 1))];
  if (kept.of == &brick && kept.generation == generation_) return kept;
  kept.of = &brick;
  kept.generation = generation_;
  kept.count = 0;
  eachCrossing(brick, coord, Vec3f::Constant(4), 16, [&kept](float x, float y, float z) {
    if (kept.count < kCrossings) {
      kept.x[kept.count] = x;
      kept.y[kept.count] = y;
      kept.z[kept.count] = z;
    }
    ++kept.count;
  });
  for (size_t i = kept.count; i < kCrossings && i % kLanes != 0; ++i) kept.x[i] = kept.y[i] = kept.z[i] = kFar;
  return kept;
}

// Offers the brick's sign changes; no other of its own is nearer to p than what it returns, which is at most `look`.
double ClosestSurface::scanBrick(const clay::Brick& brick, Coord coord, const Vec3d& p, Candidates& candidates,
                                 double look) ARGIL_REALTIME {
  const Vec3d corner = (coord * clay::kBrickEdge).toVec3d();
  const Vec3f local = (p - corner).cast<float>();
  float nearest2 = static_cast<float>(look * look);
  const Crossings& kept = crossings(brick, coord);
  if (kept.count <= kCrossings) {
    const hn::FixedTag<float, kLanes> d;
    const auto px = hn::Set(d, local.x()), py = hn::Set(d, local.y()), pz = hn::Set(d, local.z());
    auto least = hn::Set(d, nearest2), best = hn::Set(d, static_cast<float>(candidates.best2));
    for (size_t i = 0; i < kept.count; i += kLanes) {
      const auto x = hn::Sub(hn::Load(d, &kept.x[i]), px), y = hn::Sub(hn::Load(d, &kept.y[i]), py),
                 z = hn::Sub(hn::Load(d, &kept.z[i]), pz);
      const auto d2 = hn::Add(hn::Mul(x, x), hn::Add(hn::Mul(y, y), hn::Mul(z, z)));
      least = hn::Min(least, d2);
      if (hn::AllFalse(d, hn::Le(d2, best))) continue;
      alignas(16) float away2[kLanes];
      hn::Store(d2, d, away2);
      for (size_t k = 0; k < kLanes; ++k)
        if (double(away2[k]) <= candidates.best2)
          candidates.add(away2[k], corner + Vec3d(kept.x[i + k], kept.y[i + k], kept.z[i + k]));
      best = hn::Set(d, static_cast<float>(candidates.best2));
    }
    nearest2 = hn::GetLane(hn::MinOfLanes(d, least));
  } else {
    // Edges reach one voxel further than the voxel that owns them.
    eachCrossing(brick, coord, local, static_cast<float>(look) + 1.0f, [&](float x, float y, float z) {
      const float d2 = (Vec3f(x, y, z) - local).squaredNorm();
      nearest2 = std::min(nearest2, d2);
      if (double(d2) <= candidates.best2) candidates.add(d2, corner + Vec3d(x, y, z));
    });
  }
  return std::sqrt(double(nearest2));
}

// From a point near the surface to the closest one of its neighbourhood: along the tangent plane towards the foot of p,
// back onto the surface, with steps that shrink when the distance does not. True when a point of the surface was met.
bool ClosestSurface::walk(const Vec3d& p, Vec3d& point, double& distance) ARGIL_REALTIME {
  Vec3d x = point, bestPoint = point;
  Vec3d tangent = Vec3d::Zero();
  double best = -1, lambda = 1;
  for (int i = 0; i < kWalkSteps; ++i) {
    // Back onto the surface.
    Vec3f g;
    float phi = sampler_.trilinear(x, g);
    double slope2 = double(g.squaredNorm());
    if (slope2 < 1e-4) break;
    if (std::abs(phi) > kOnSurface) {
      x -= std::clamp(double(phi) / slope2, -1.0, 1.0) * g.cast<double>();
      phi = sampler_.trilinear(x, g);
      slope2 = double(g.squaredNorm());
      if (slope2 < 1e-4) break;
    }
    const bool onSurface = std::abs(phi) <= 4 * kOnSurface;
    const double d = (x - p).norm();
    if (onSurface && (best < 0 || d < best)) {
      const bool little = best >= 0 && best - d < 1e-5;
      best = d;
      bestPoint = x;
      const Vec3d normal = g.cast<double>() / std::sqrt(slope2);
      tangent = (p - x) - normal * normal.dot(p - x);
      if (little || tangent.norm() < kWalkDone) break;
    } else {
      if (best < 0) {  // Not on it yet: one more projection.
        continue;
      }
      lambda *= 0.3;
      if (lambda < 5e-3) break;
    }
    const double length = tangent.norm();
    x = bestPoint + tangent * (lambda * std::min(1.0, 0.5 / length));
  }
  if (best < 0) return false;
  point = bestPoint;
  distance = best;
  return true;
}

// Calls visit for every brick that the sphere about p meets, row by row; the sphere may shrink meanwhile.
template <class Visit>
void ClosestSurface::eachBrick(const Vec3d& p, const double& reach2, Visit visit) ARGIL_REALTIME {
  const double edge = clay::kBrickEdge;
  const auto cell = [edge](double v) { return static_cast<int32_t>(std::floor(v / edge)); };
  const auto gap = [edge](int32_t brick, double v) {
    return std::max({0.0, double(brick) * edge - v, v - double(brick + 1) * edge});
  };
  const double radius = std::sqrt(reach2);
  // A brick lower than the sphere may own an edge that ends in it.
  for (int32_t bx = cell(p.x() - radius - 1); bx <= cell(p.x() + radius); ++bx) {
    const double gx = gap(bx, p.x());
    const double leftX = reach2 - gx * gx;
    if (leftX < 0) continue;
    const double halfY = std::sqrt(leftX);
    for (int32_t by = cell(p.y() - halfY - 1); by <= cell(p.y() + halfY); ++by) {
      const double gy = gap(by, p.y());
      const double leftY = leftX - gy * gy;
      if (leftY < 0) continue;
      const double halfZ = std::sqrt(leftY);
      const int32_t lastZ = cell(p.z() + halfZ);
      for (int32_t bz = cell(p.z() - halfZ - 1); bz <= lastZ; ++bz) {
        const Coord c{bx, by, bz};
        if (gap2(c, p) > reach2) continue;
        const clay::Slot slot = sampler_.slot(c);
        if (!slot.isTile()) visit(*slot.brick(), c);
      }
    }
  }
}

// Looks through the bricks that may hold something nearer than the best answer so far. Bricks around, and how far each
// one's nearest sign change was from where it was looked for, are kept while the version stays and p moves little.
void ClosestSurface::scan(const Vec3d& p, Candidates& candidates) ARGIL_REALTIME {
  const double radius = std::sqrt(candidates.best2);
  if (!(covered_ >= 0 && (p - centre_).norm() + radius <= covered_)) {
    centre_ = p;
    covered_ = radius + kAhead;
    memory_->knownCount = 0;
    eachBrick(p, covered_ * covered_, [&](const clay::Brick& brick, Coord c) {
      if (memory_->knownCount < kKnown) memory_->known[memory_->knownCount] = {&brick, c, 0, p};
      ++memory_->knownCount;
    });
    if (memory_->knownCount > kKnown) covered_ = -1;
  }
  if (covered_ < 0) {  // More than can be kept.
    eachBrick(p, candidates.best2, [&](const clay::Brick& brick, Coord c) {
      scanBrick(brick, c, p, candidates, std::sqrt(candidates.best2));
    });
    return;
  }
  for (size_t i = 0; i < memory_->knownCount; ++i) {
    Known& k = memory_->known[i];
    const double limit = std::sqrt(candidates.best2);
    // Nothing is nearer than k.bound to k.from, so nothing of it is nearer to p than that less the way.
    const double spare = k.bound - limit;
    if ((spare > 0 && (p - k.from).squaredNorm() < spare * spare) || gap2(k.coord, p) > candidates.best2) continue;
    k.bound = scanBrick(*k.brick, k.coord, p, candidates, limit + kLook);
    k.from = p;
  }
}

SurfacePoint ClosestSurface::nearest(const Vec3d& p, double reach, const Vec3d* hint) ARGIL_REALTIME {
  SurfacePoint result;
  if (!p.allFinite()) return result;
  reach = std::min(reach, kMaxReach);
  // Far outside of the tree's reach nothing can be; it also keeps the conversions below defined.
  if (p.cwiseAbs().maxCoeff() > 8.0 * clay::kBrickReach + 2 * kMaxReach) return result;
  Candidates candidates(reach);
  const auto offer = [&](Vec3d x) {
    const Vec3d from = x;
    double d = 0;
    if (!walk(p, x, d)) return;
    if (hidden(x)) {  // The rim lies between both.
      if (hidden(from)) return;
      Vec3d seen = from;
      for (int i = 0; i < kRimHalvings; ++i) {
        const Vec3d middle = 0.5 * (seen + x);
        (hidden(middle) ? x : seen) = middle;
      }
      x = seen;
      d = (x - p).norm();
    }
    if (d > reach || (result.found && d >= result.distance)) return;
    result = {true, x, d};
    candidates.improve(d);
  };
  if (hint) offer(*hint);

  scan(p, candidates);
  for (int i = 0; i < candidates.count; ++i) {
    if (double(candidates.distance2[size_t(i)]) > candidates.best2) break;
    if (!result.found || double(candidates.distance2[size_t(i)]) < result.distance * result.distance)
      result = {true, candidates.point[size_t(i)], std::sqrt(double(candidates.distance2[size_t(i)]))};
    else {
      // What was walked to is the closest of its neighbourhood; one that does not rise above its tangent plane is of
      // that patch.
      const Vec3d apart = candidates.point[size_t(i)] - result.point;
      if (apart.squaredNorm() < kPatch2 && apart.dot(p - result.point) < kPatchRise * result.distance) continue;
    }
    offer(candidates.point[size_t(i)]);
  }
  if (result.distance > reach) result.found = false;
  return result;
}

}  // namespace argil::haptics
