#include "clay/mesh/edge_collapse.h"

#include <algorithm>
#include <bit>
#include <cmath>
#include <numeric>
#include <utility>

#include "clay/base/error.h"

namespace argil::clay {

namespace {

/// A triangle may turn by 78° in one collapse: more would let folds come up, less would keep round things from becoming
/// coarse.
constexpr double kLeastCosine = 0.2;
/// Twice the area over the longest edge squared. Triangles thinner than this are not made, unless they were thinner
/// before.
constexpr double kThin = 0.02;
/// A triangle thinner than this has no direction that could turn.
constexpr double kFlat = 1e-12;
/// The cost of moving along what is flat, against moving off it: orders what would else be equal, shortest first.
constexpr double kShort = 1e-6;
constexpr double kHold = 1e-6;
/// Edges of a vertex. Keeps one collapse cheap; no good mesh has more.
constexpr size_t kMostEdges = 64;
/// Farther than so many edge lengths from the edge a minimum is not looked for: the planes are nearly parallel there.
constexpr double kFarthest = 1.5;
/// Queue: costs within 3 % are equal, first come first served, which walks along memory.
constexpr int kCostShift = 18;
constexpr size_t kQueues = size_t{1} << (31 - kCostShift);
constexpr uint32_t kWatchEvery = 16384;
/// A sweep over all edges that are left must have removed this part of the triangles for another to be worth it.
constexpr double kWorthAnother = 0.001;

size_t queueOf(float cost) {
  return std::bit_cast<uint32_t>(cost) >> kCostShift;
}

}  // namespace

EdgeCollapse::EdgeCollapse(const TriangleMesh& mesh, std::optional<Bound> bound, const Watch& watch)
    : mesh_(mesh), bound_(std::move(bound)) {
  if (mesh.triangles.size() > UINT32_MAX / 3 - 1)
    throw Error("a mesh of more than 1 431 655 763 triangles cannot be reduced: split it");
  Eigen::AlignedBox3d box;
  for (const auto& t : mesh.triangles)
    for (const uint32_t v : t) box.extend(mesh.positions[v]);
  middle_ = box.center();
  // Costs are mm⁴; as parts of the whole they stay within a float whatever the size.
  const double diagonal2 = box.diagonal().squaredNorm();
  costScale_ = diagonal2 > 0 ? 1 / (diagonal2 * diagonal2) : 1;
  positions_.reserve(mesh.positions.size());
  for (const Vec3d& p : mesh.positions) positions_.push_back(p - middle_);
  vertex_.reserve(3 * mesh.triangles.size());
  for (const auto& t : mesh.triangles) vertex_.insert(vertex_.end(), t.begin(), t.end());
  alive_ = mesh.triangles.size();
  watch(alive_);
  pairEdges();
  watch(alive_);
  findFans();
  addQuadrics();
  watch(alive_);
  changed_.assign(positions_.size(), 0);
  queue_.resize(kQueues);
  if (bound_) {
    original_.emplace(mesh);
    firstGuest_.assign(mesh.triangles.size(), kNone);
    nextGuest_.assign(positions_.size(), kNone);
    for (uint32_t v = 0; v < positions_.size(); ++v)
      if (!held(v)) nextGuest_[v] = std::exchange(firstGuest_[start_[v] / 3], v);
  }
}

void EdgeCollapse::pairEdges() {
  twin_.assign(vertex_.size(), kNone);
  // Half-edges by where they begin. Counts are kept two places up, so that filling moves each start to its final place.
  std::vector<uint32_t> first(positions_.size() + 2, 0), out(vertex_.size());
  for (const uint32_t v : vertex_) ++first[v + 2];
  std::partial_sum(first.begin(), first.end(), first.begin());
  for (HalfEdge h = 0; h < vertex_.size(); ++h) out[first[vertex_[h] + 1]++] = h;
  for (HalfEdge h = 0; h < vertex_.size(); ++h) {
    if (twin_[h] != kNone) continue;
    const uint32_t from = vertex_[h], to = vertex_[next(h)];
    // Looked up at the end with fewer edges: some meshes have a vertex with millions.
    const bool atTo = first[to + 1] - first[to] < first[from + 1] - first[from];
    const uint32_t here = atTo ? to : from, there = atTo ? from : to;
    HalfEdge found = kNone;
    int backward = 0, forward = 0;
    for (uint32_t i = first[here]; i < first[here + 1]; ++i) {
      const HalfEdge leaving = out[i], arriving = before(out[i]);
      if (vertex_[next(leaving)] == there) {
        ++(atTo ? backward : forward);
        if (atTo) found = leaving;
      }
      if (vertex_[arriving] == there) {
        ++(atTo ? forward : backward);
        if (!atTo) found = arriving;
      }
    }
    // Anything else than one each way is no edge of a closed surface: it stays unpaired, and its ends are held.
    if (backward == 1 && forward == 1 && from != to) twin_[h] = found, twin_[found] = h;
  }
}

void EdgeCollapse::findFans() {
  start_.assign(positions_.size(), kNone);
  std::vector<uint32_t> edges(positions_.size(), 0);
  for (HalfEdge h = 0; h < vertex_.size(); ++h) {
    ++edges[vertex_[h]];
    start_[vertex_[h]] = h;
  }
  for (uint32_t v = 0; v < positions_.size(); ++v) {
    if (start_[v] == kNone) continue;
    uint32_t walked = 0;
    HalfEdge h = start_[v];
    do {
      h = twin_[before(h)];
      ++walked;
    } while (h != kNone && h != start_[v] && walked < edges[v]);
    if (h != start_[v] || walked != edges[v] || walked < 3 || (bound_ && !bound_->fixed.empty() && bound_->fixed[v]))
      start_[v] = kNone;
    movable_ += start_[v] != kNone;
  }
}

void EdgeCollapse::addQuadrics() {
  quadrics_.assign(positions_.size(), {});
  for (HalfEdge h = 0; h < vertex_.size(); h += 3) {
    const Vec3d &a = positions_[vertex_[h]], &b = positions_[vertex_[h + 1]], &c = positions_[vertex_[h + 2]];
    const Vec3d cross = (b - a).cross(c - a);
    const double length = cross.norm();
    if (!(length > 0)) continue;
    const Vec3d n = cross / length;
    for (int k = 0; k < 3; ++k) quadrics_[vertex_[h + static_cast<HalfEdge>(k)]].addPlane(n, -n.dot(a), length / 6);
  }
}

EdgeCollapse::Goal EdgeCollapse::goal(HalfEdge h) const {
  const uint32_t u = vertex_[h], v = vertex_[next(h)];
  const Quadric q = quadrics_[u] + quadrics_[v];
  const Vec3d middle = (positions_[u] + positions_[v]) / 2;
  const double length2 = (positions_[u] - positions_[v]).squaredNorm();
  Vec3d at = q.least(middle, kHold);
  double cost = q.at(at);
  if ((at - middle).squaredNorm() > kFarthest * kFarthest * length2) {
    at = middle, cost = q.at(middle);
    for (const uint32_t end : {u, v})
      if (const double there = q.at(positions_[end]); there < cost) at = positions_[end], cost = there;
  }
  return {at, static_cast<float>((cost + kShort * q.weight() * length2) * costScale_)};
}

void EdgeCollapse::push(HalfEdge h) {
  const float cost = goal(h).cost;
  const size_t at = std::isfinite(cost) ? queueOf(cost) : kQueues - 1;
  queue_[at].push_back({h, collapses_});
  cheapest_ = std::min(cheapest_, at);
}

void EdgeCollapse::pushAll() {
  for (HalfEdge h = 0; h < vertex_.size(); ++h) {
    if (vertex_[h] == kNone || twin_[h] == kNone || h > twin_[h]) continue;
    if (!held(vertex_[h]) && !held(vertex_[next(h)])) push(h);
  }
}

void EdgeCollapse::run(uint64_t triangles, const Watch& watch) {
  uint32_t untilWatch = kWatchEvery;
  while (alive_ > triangles) {
    // What could not go when its turn came may go now that its surroundings have changed.
    const uint64_t atBegin = alive_;
    pushAll();
    for (; cheapest_ < kQueues; ++cheapest_) {
      while (!queue_[cheapest_].empty()) {
        if (alive_ <= triangles) break;
        if (--untilWatch == 0) untilWatch = kWatchEvery, watch(alive_);
        std::deque<Waiting>& waiting = queue_[cheapest_];
        const Waiting w = waiting.front();
        waiting.pop_front();
        if (vertex_[w.edge] == kNone || changed_[vertex_[w.edge]] > w.since ||
            changed_[vertex_[next(w.edge)]] > w.since)
          continue;
        tryCollapse(w.edge);  // May lower cheapest_.
      }
      if (alive_ <= triangles) break;
    }
    for (auto& waiting : queue_) waiting.clear();
    cheapest_ = kQueues;
    if (double(atBegin - alive_) <= kWorthAnother * double(atBegin)) break;
  }
}

bool EdgeCollapse::ring(uint32_t v, std::vector<HalfEdge>& out) const {
  out.clear();
  HalfEdge h = start_[v];
  do {
    out.push_back(h);
    h = twin_[before(h)];
  } while (h != start_[v] && out.size() <= kMostEdges);
  return out.size() <= kMostEdges;
}

bool EdgeCollapse::staysUpright(const std::vector<HalfEdge>& out, HalfEdge gone1, HalfEdge gone2,
                                const Vec3d& at) const {
  for (const HalfEdge h : out) {
    if (h / 3 == gone1 / 3 || h / 3 == gone2 / 3) continue;
    const Vec3d &old = positions_[vertex_[h]], &a = positions_[vertex_[next(h)]], &b = positions_[vertex_[before(h)]];
    const Vec3d ab = b - a, oldA = a - old, newA = a - at;
    const Vec3d was = oldA.cross(ab), is = newA.cross(ab);
    const double ab2 = ab.squaredNorm();
    const double wasLong = std::max({ab2, oldA.squaredNorm(), (b - old).squaredNorm()});
    const double isLong = std::max({ab2, newA.squaredNorm(), (b - at).squaredNorm()});
    const double wasTwice = was.norm(), isTwice = is.norm();
    if (isTwice < kThin * isLong && isTwice * wasLong < wasTwice * isLong) return false;
    if (wasTwice > kFlat * wasLong && !(was.dot(is) > kLeastCosine * wasTwice * isTwice)) return false;
  }
  return true;
}

bool EdgeCollapse::staysNear(HalfEdge h, HalfEdge g, const Vec3d& at) {
  const auto near = [&](const Vec3d& p) { return original_->within(p + middle_, bound_->mm); };
  if (!near(at)) return false;
  fan_.clear(), fanTriangles_.clear(), moves_.clear();
  for (const auto* out : {&ringU_, &ringV_})
    for (const HalfEdge e : *out) {
      if (e / 3 == h / 3 || e / 3 == g / 3) continue;
      fan_.push_back({at, positions_[vertex_[next(e)]], positions_[vertex_[before(e)]]});
      fanTriangles_.push_back(e / 3);
    }
  const double most = bound_->mm * bound_->mm;
  const auto place = [&](uint32_t guest) {
    const Vec3d p = mesh_.positions[guest] - middle_;
    double best = INFINITY;
    size_t where = 0;
    for (size_t i = 0; i < fan_.size(); ++i) {
      const double squared = (nearestOnTriangle(p, fan_[i][0], fan_[i][1], fan_[i][2]) - p).squaredNorm();
      if (squared < best) best = squared, where = i;
    }
    if (best > most) return false;
    moves_.push_back({guest, fanTriangles_[where]});
    return true;
  };
  for (const auto* out : {&ringU_, &ringV_})
    for (const HalfEdge e : *out) {
      if (out == &ringV_ && (e / 3 == h / 3 || e / 3 == g / 3)) continue;
      for (uint32_t guest = firstGuest_[e / 3]; guest != kNone; guest = nextGuest_[guest])
        if (!place(guest)) return false;
    }
  for (const auto& [p, a, b] : fan_)
    if (!near((p + a) / 2) || !near((p + a + b) / 3)) return false;
  for (const uint32_t t : fanTriangles_) firstGuest_[t] = kNone;
  for (const Move& move : moves_) nextGuest_[move.guest] = std::exchange(firstGuest_[move.triangle], move.guest);
  return true;
}

bool EdgeCollapse::tryCollapse(HalfEdge h) {
  const HalfEdge g = twin_[h];
  const uint32_t u = vertex_[h], v = vertex_[g];
  if (!ring(u, ringU_) || !ring(v, ringV_) || ringU_.size() + ringV_.size() > kMostEdges) return false;
  // The link condition (Dey, Edelsbrunner, Guha, Nekhayev: Topology preserving edge contraction, 1999): the ends share
  // the two vertices opposite the edge, and no edge beside it, which happens in a tetrahedron alone.
  if (ringU_.size() == 3 && ringV_.size() == 3) return false;
  int shared = 0;
  for (const HalfEdge a : ringU_)
    for (const HalfEdge b : ringV_) shared += vertex_[next(a)] == vertex_[next(b)];
  if (shared != 2) return false;
  const Vec3d at = goal(h).at;
  if (!staysUpright(ringU_, h, g, at) || !staysUpright(ringV_, h, g, at)) return false;
  if (bound_ && !staysNear(h, g, at)) return false;

  ++collapses_;
  for (const HalfEdge e : ringU_) vertex_[e] = v;
  for (const HalfEdge e : {h, g}) {
    // The two other edges of the triangle become one.
    const HalfEdge x = twin_[next(e)], y = twin_[before(e)];
    const uint32_t apex = vertex_[before(e)];
    twin_[x] = y, twin_[y] = x;
    // y leaves v or arrives there, x the other way; x begins at the apex.
    if (!held(apex)) start_[apex] = x;
    start_[v] = y;
    for (HalfEdge corner = e - e % 3, k = 0; k < 3; ++k) vertex_[corner + k] = kNone;
  }
  start_[u] = kNone;
  positions_[v] = at;
  quadrics_[v] = quadrics_[u] + quadrics_[v];
  changed_[u] = changed_[v] = collapses_;
  alive_ -= 2;
  ring(v, ringU_);
  for (const HalfEdge e : ringU_)
    if (!held(vertex_[next(e)])) push(e);
  return true;
}

TriangleMesh EdgeCollapse::result() const {
  TriangleMesh reduced;
  std::vector<uint32_t> number(positions_.size(), kNone);
  for (const uint32_t v : vertex_)
    if (v != kNone) number[v] = 0;
  for (uint32_t v = 0; v < number.size(); ++v) {
    if (number[v] == kNone) continue;
    number[v] = static_cast<uint32_t>(reduced.positions.size());
    reduced.positions.push_back(changed_[v] == 0 ? mesh_.positions[v] : Vec3d(positions_[v] + middle_));
  }
  reduced.triangles.reserve(alive_);
  for (size_t h = 0; h < vertex_.size(); h += 3)
    if (vertex_[h] != kNone)
      reduced.triangles.push_back({number[vertex_[h]], number[vertex_[h + 1]], number[vertex_[h + 2]]});
  return reduced;
}

}  // namespace argil::clay
