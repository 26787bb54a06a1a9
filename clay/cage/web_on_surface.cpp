#include "clay/cage/web_on_surface.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <tuple>
#include <utility>

#include "clay/cage/least_near.h"

namespace argil::clay {

namespace {

// What unfolds a quad is better by so much of a scaled Jacobian.
constexpr double kBetter = 0.01;
constexpr double kLeastEdge = 0.1;   // of the finest: evening out makes none shorter than that
constexpr double kNearCrease = 0.5;  // of a size: a vertex of a line that is so near goes onto the crease
// Edges: a vertex of a line that is so near may be a corner of the clay; and so much farther where that is one of more
// lines than the vertex.
constexpr double kCornerNear = 2, kUnlike = 1.5;
// How far the middle of an edge or of a quad may lie off the surface, of its length; the next one where no collapse is
// left with the one before.
constexpr double kBulges[WebOnSurface::kStages] = {0.2, 0.3, 0.45, 1e9};
// And of a wall: from its middle on it would become lower row by row, until it is gone.
constexpr double kOfWall[WebOnSurface::kStages] = {0.35, 0.4, 0.45, 1e9};

double leastOf(const std::vector<float>& all) {
  return all.empty() ? 0 : double(*std::min_element(all.begin(), all.end()));
}

}  // namespace

struct WebOnSurface::Around {
  double longest = 0, reach;  // edge of the surface's triangles, and so far, mm
  std::vector<float> sizes, walls;

  explicit Around(const WebGround& ground) {
    const std::vector<Vec3d>& places = ground.surface.positions;
    for (const auto& t : ground.surface.triangles)
      for (size_t s = 0; s < 3; ++s) longest = std::max(longest, (places[t[s]] - places[t[(s + 1) % 3]]).squaredNorm());
    longest = std::sqrt(longest);
    reach =
        std::accumulate(ground.sizes.begin(), ground.sizes.end(), 0.0) / double(std::max<size_t>(1, places.size())) +
        2 * longest;
    sizes = leastNear(places, ground.sizes, reach);
    walls = leastNear(places, ground.walls, reach);
  }
};

WebOnSurface::WebOnSurface(QuadMesh mesh, const WebGround& ground)
    : web_(std::move(mesh)),
      ground_(ground),
      near_(web_.quads(), kNoneNear),
      around_(std::make_shared<Around>(ground)),
      least_(leastOf(ground.sizes)),
      thinnest_(leastOf(ground.walls)) {
  keepFor(web_.vertices());
  std::vector<Vec3d> beside(web_.vertices());  // the surface, as a coarser grid has it
  for (uint32_t v = 0; v < web_.vertices(); ++v) beside[v] = web_.at(v), place(v, web_.at(v));
  placeCorners(beside);
  // Of a crumb all of them may have come to one place.
  for (uint32_t v = 0; v < web_.vertices(); ++v) {
    web_.beside(v, beside_);
    if (shortestAt(v) < kLeastMade * ground_.finest && !web_.isOnCrease(v)) web_.move(v, beside[v]);
  }
}

void WebOnSurface::keepFor(size_t vertices, uint32_t hint) {
  hints_.resize(vertices, hint);
  creaseHints_.resize(vertices, UINT32_MAX);
  size_.resize(vertices, 0);
  normals_.resize(vertices, Vec3d::Zero());
}

void WebOnSurface::place(uint32_t v, const Vec3d& p) {
  if (web_.isOnCrease(v)) {
    if (!web_.isCorner(v)) {
      const CreaseMap::Hit hit = ground_.creases.nearest(p, creaseHints_[v]);
      // In a gap that was bridged there is none.
      const double near = std::max(2 * ground_.finest, kNearCrease * size_[v]);
      if (hit.squared < near * near || isOnLine(v)) return placeAt(v, hit.mm);
    } else if (size_[v] > 0) {
      return placeAt(v, web_.at(v));
    }
  }
  placeOnSurface(v, p);
}
bool WebOnSurface::isOnLine(uint32_t v) {
  return ground_.creases.nearest(web_.at(v), creaseHints_[v]).squared <
         kLeastMade * kLeastMade * ground_.finest * ground_.finest;
}
void WebOnSurface::placeAt(uint32_t v, const Vec3d& p) {
  placeOnSurface(v, p);
  web_.move(v, p);
  Vec3d sum = Vec3d::Zero();
  for (const uint32_t f : web_.around(v)) {
    const auto& q = web_.quad(f);
    sum += (web_.at(q[2]) - web_.at(q[0])).cross(web_.at(q[3]) - web_.at(q[1])).normalized();
  }
  if (sum.squaredNorm() > 0) normals_[v] = sum.normalized();
}
void WebOnSurface::placeOnSurface(uint32_t v, const Vec3d& p) {
  const NearestTriangle::Hit hit = ground_.tree.nearest(p, hints_[v]);
  hints_[v] = hit.triangle;
  const auto& c = ground_.tree.corners(hit.triangle);
  const Vec3d &x = ground_.surface.positions[c[0]], &y = ground_.surface.positions[c[1]],
              &z = ground_.surface.positions[c[2]];
  web_.move(v, nearestOnTriangle(p, x, y, z));
  size_[v] = sizeOf(hit);
  const Vec3d n = (y - x).cross(z - x);
  if (n.squaredNorm() > 0) normals_[v] = n.normalized();
}

// `before`: where the vertices of lines were. Corners of the clay, each at the nearest vertex of a line; where
// creases meet at one where lines do, if there is one near by.
void WebOnSurface::placeCorners(const std::vector<Vec3d>& before) {
  std::vector<std::tuple<double, uint32_t, uint32_t>> pairs;  // distance, vertex, corner
  for (uint32_t v = 0; v < web_.vertices(); ++v) {
    if (!web_.isOnCrease(v)) continue;
    web_.alongCreases(v, pulling_);
    double length = 0;
    for (const uint32_t each : pulling_) length += (web_.at(each) - web_.at(v)).norm() / double(pulling_.size());
    for (uint32_t k = 0; k < ground_.creases.corners().size(); ++k)
      if (const double away = (ground_.creases.corners()[k] - web_.at(v)).norm(); away < kCornerNear * length)
        pairs.emplace_back(k < ground_.creases.meetings() && pulling_.size() < 3 ? away + kUnlike * length : away, v,
                           k);
  }
  std::sort(pairs.begin(), pairs.end());
  std::vector<bool> placed(web_.vertices()), taken(ground_.creases.corners().size());
  for (const auto& [away, vertex, corner] : pairs) {
    if (placed[vertex] || taken[corner]) continue;
    placed[vertex] = taken[corner] = true;
    web_.markCorner(vertex);
    placeAt(vertex, ground_.creases.corners()[corner]);
  }
  // Lines that meet elsewhere: two such may be one corner of the clay, so they stay apart as they are.
  for (uint32_t v = 0; v < web_.vertices(); ++v)
    if (web_.isCorner(v) && !placed[v]) placeAt(v, before[v]);
}

double WebOnSurface::sizeOf(const NearestTriangle::Hit& hit) const {
  const auto& c = ground_.tree.corners(hit.triangle);
  return (double(ground_.sizes[c[0]]) + double(ground_.sizes[c[1]]) + double(ground_.sizes[c[2]])) / 3;
}

double WebOnSurface::shapeAt(uint32_t v) const {
  double least = 1;
  for (const uint32_t f : web_.around(v)) {
    const auto& q = web_.quad(f);
    const Vec3d own = (web_.at(q[2]) - web_.at(q[0])).cross(web_.at(q[3]) - web_.at(q[1])).normalized();
    const auto s = size_t(std::find(q.begin(), q.end(), v) - q.begin());
    for (const size_t corner : {s, (s + 1) & 3, (s + 3) & 3}) {
      const Vec3d& p = web_.at(q[corner]);
      const Vec3d a = web_.at(q[(corner + 1) & 3]) - p, b = web_.at(q[(corner + 3) & 3]) - p;
      const double lengths = a.norm() * b.norm();
      const Vec3d& outwards = web_.isOnCrease(q[corner]) ? own : normals_[q[corner]];
      least = std::min(least, lengths > 0 ? a.cross(b).dot(outwards) / lengths : -1);
    }
  }
  return least;
}

// How far a place between vertices lies off the surface, in parts of what is allowed; 0 where that is little. Of what
// is long beside the size of the surface there only that size counts: a thin wall is not cut through. `hint`: a
// triangle near by; the nearest one afterwards, or one that is near enough.
double WebOnSurface::off(const Vec3d& p, double length, uint32_t& hint) const {
  if (stage_ + 1 >= kStages) return 0;
  const auto allowed = [&](double size, double wall) {
    return std::min(kOfWall[stage_] * wall, std::max(ground_.finest, kBulges[stage_] * std::min(length, 2 * size)));
  };
  double little = allowed(least_, thinnest_);
  if (hint != UINT32_MAX) {
    // The nearest triangle, whichever it is, has a corner as near to the hint's as that.
    const double squared = ground_.tree.squaredTo(hint, p);
    if (2 * (std::sqrt(squared) + around_->longest) <= around_->reach) {
      const uint32_t beside = ground_.tree.corners(hint)[0];
      little = allowed(double(around_->sizes[beside]), double(around_->walls[beside]));
    }
    if (squared <= little * little) return 0;
  }
  const NearestTriangle::Hit hit = ground_.tree.nearEnough(p, little, hint);
  hint = hit.triangle;
  if (hit.squared <= little * little) return 0;
  const auto& c = ground_.tree.corners(hit.triangle);
  const double wall = double(std::min({ground_.walls[c[0]], ground_.walls[c[1]], ground_.walls[c[2]]}));
  return std::sqrt(hit.squared) / allowed(sizeOf(hit), wall);
}
double WebOnSurface::middleOff(const Vec3d& p, const Vec3d& q, uint32_t& hint) const {
  return off(0.5 * (p + q), (p - q).norm(), hint);
}
double WebOnSurface::offAround(uint32_t v, const Vec3d& to, uint32_t without) const {
  double most = 0;
  for (const uint32_t each : web_.around(v)) {
    if (each == without) continue;
    const auto& q = web_.quad(each);
    const auto s = size_t(std::find(q.begin(), q.end(), v) - q.begin());
    Near& near = near_[each];
    for (const size_t place : {s, size_t{4}})
      if (near[place] == UINT32_MAX) near[place] = hints_[v];
    const Vec3d &next = web_.at(q[(s + 1) & 3]), &far = web_.at(q[(s + 2) & 3]), &last = web_.at(q[(s + 3) & 3]);
    most = std::max({most, middleOff(to, next, near[s]),
                     off(0.25 * (to + next + far + last), 0.5 * ((to - far).norm() + (next - last).norm()), near[4])});
  }
  return most;
}

double WebOnSurface::shortestAt(uint32_t v) const {
  double shortest = INFINITY;
  for (const uint32_t each : beside_) shortest = std::min(shortest, (web_.at(each) - web_.at(v)).norm());
  return shortest;
}

// Where each of the two lines of edges through v has it between its ends. The mean of all four ends would draw a row
// of vertices beside a curved crease onto it: the row's own ends lie on the inner side.
Vec3d WebOnSurface::alongLines(uint32_t v) const {
  Vec3d to = web_.at(v);
  for (const auto& [a, c] : web_.linesThrough(v)) {
    const double ha = sizeBetween(v, a), hc = sizeBetween(v, c);
    const Vec3d way = (web_.at(c) - web_.at(a)).normalized();
    const Vec3d middle = (hc * hc * web_.at(a) + ha * ha * web_.at(c)) / (ha * ha + hc * hc);
    to += (middle - web_.at(v)).dot(way) * way;
  }
  return to;
}

void WebOnSurface::relax(uint32_t v) {
  if (web_.isCorner(v)) return;
  web_.alongCreases(v, pulling_);
  web_.beside(v, beside_);
  const bool inside = pulling_.empty();
  if (inside) pulling_ = beside_;
  Vec3d sum = Vec3d::Zero();
  double weights = 0;
  for (const uint32_t each : pulling_) {
    const double h = sizeBetween(v, each), weight = 1 / (h * h);
    sum += weight * web_.at(each);
    weights += weight;
  }
  const Vec3d was = web_.at(v), normal = normals_[v];
  const double size = size_[v], before = shapeAt(v), shortest = shortestAt(v);
  Vec3d mean = sum / weights;
  if (inside && web_.around(v).size() == 4 &&
      std::ranges::any_of(beside_, [&](uint32_t each) { return web_.isOnCrease(each); }))
    mean = alongLines(v);
  place(v, was + 0.5 * (mean - was));
  bool worse =
      shapeAt(v) < std::min(before, kLeastJacobian) || shortestAt(v) < std::min(shortest, kLeastEdge * ground_.finest);
  if (const double now = worse ? 0 : offAround(v, web_.at(v)); now > 1) worse = now > offAround(v, was);
  if (worse) {
    web_.move(v, was);
    normals_[v] = normal;
    size_[v] = size;
  }
}

// Towards what is beside it, or away from it.
void WebOnSurface::unfold(uint32_t v, double leastEdge) {
  if (web_.around(v).empty() || web_.isCorner(v)) return;
  double most = shapeAt(v);
  if (most > kGoodJacobian) return;
  const Vec3d was = web_.at(v);
  const double offBefore = std::max(1.0, offAround(v, was));
  std::vector<Vec3d> places;
  web_.beside(v, beside_);
  web_.alongCreases(v, pulling_);
  if (pulling_.empty()) {
    for (const uint32_t f : web_.around(v)) {
      const auto& q = web_.quad(f);
      places.push_back(0.25 * (web_.at(q[0]) + web_.at(q[1]) + web_.at(q[2]) + web_.at(q[3])));
    }
    pulling_ = beside_;
  }
  for (const uint32_t each : pulling_) places.push_back(0.5 * (was + web_.at(each)));
  Vec3d best = was;
  const double shortest = std::min(shortestAt(v), std::max(kLeastEdge * ground_.finest, leastEdge * size_[v]));
  for (const Vec3d& towards : places)
    for (const double share : {0.5, 1.0, -0.5}) {
      place(v, was + share * (towards - was));
      if (shapeAt(v) < most + kBetter || shortestAt(v) < shortest || offAround(v, web_.at(v)) > offBefore) continue;
      most = shapeAt(v);
      best = web_.at(v);
    }
  place(v, best);
}

Vec3d WebOnSurface::onSurface(const Vec3d& p, uint32_t near) const {
  const auto& t = ground_.tree.corners(ground_.tree.nearest(p, hints_[near]).triangle);
  const std::vector<Vec3d>& at = ground_.surface.positions;
  return nearestOnTriangle(p, at[t[0]], at[t[1]], at[t[2]]);
}

double WebOnSurface::edgeOff(uint32_t from, uint32_t to) const {
  uint32_t hint = hints_[from];
  return middleOff(web_.at(from), web_.at(to), hint);
}

std::vector<uint32_t> WebOnSurface::replace(const std::vector<uint32_t>& going,
                                            const std::vector<std::array<uint32_t, 4>>& quads,
                                            const std::vector<uint32_t>& free,
                                            const std::vector<std::vector<uint32_t>>& lines) {
  std::vector<uint32_t> made = web_.replace(going, quads, free, lines);
  near_.resize(web_.quads(), kNoneNear);
  return made;
}

uint32_t WebOnSurface::add(const Vec3d& at, uint32_t near) {
  const uint32_t v = web_.add(at);
  keepFor(web_.vertices(), hints_[near]);
  placeOnSurface(v, at);
  return v;
}

void WebOnSurface::takeBack(uint32_t first) {
  web_.takeBack(first);
  keepFor(first);
}

QuadWeb::Kept WebOnSurface::forgetGone() {
  QuadWeb::Kept kept = web_.forgetGone();
  keepOnly(hints_, kept.vertices);
  keepOnly(creaseHints_, kept.vertices);
  keepOnly(size_, kept.vertices);
  keepOnly(normals_, kept.vertices);
  keepOnly(near_, kept.quads);
  return kept;
}

void WebOnSurface::putBack(const Place& place) {
  web_.move(place.vertex, place.at);
  normals_[place.vertex] = place.normal;
  size_[place.vertex] = place.size;
}

}  // namespace argil::clay
