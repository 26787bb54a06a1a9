#include "clay/cage/coarsen_quads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <set>
#include <tuple>
#include <utility>

#include "clay/cage/quad_patches.h"
#include "clay/cage/quad_web.h"

namespace argil::clay {

namespace {

constexpr double kUneven = 0.2;  // of a diagonal's length: what nearness to four quads a vertex counts
constexpr double kLeastFactor = 0.4;
// Scaled Jacobians: evening out leaves none below the first that was not, at the end vertices move for those below the
// second, if they become better by the third.
constexpr double kLeastJacobian = 0.2, kGoodJacobian = 0.4, kBetter = 0.01;
constexpr double kLeastEdge = 0.1;   // of the finest: evening out makes none shorter than that,
constexpr double kLeastMade = 0.02;  // and nothing else one shorter than that
constexpr int kAtFirst = 3;          // rounds that make edges even, where there are creases
constexpr int kAtTheEnd = 20;        // rounds that make edges even
constexpr int kOfHalved = 6;         // rounds that make those of halved quads even
constexpr size_t kStepEach = 512;
constexpr double kLastShare = 1.3;   // times the quads that are asked for: from there on lines keep two quads a vertex
constexpr double kNearCrease = 0.5;  // of a size: a vertex of a line that is so near goes onto the crease
// Edges: a vertex of a line that is so near may be a corner of the clay; and so much farther where that is one of more
// lines than the vertex.
constexpr double kCornerNear = 2, kUnlike = 1.5;
constexpr double kLongestCut = 3;  // sizes: two edges of a line that are longer keep what lies between them
constexpr double kOfLine = 0.8;    // what a diagonal beside two edges of a line counts of its length
// Disks of quads that are filled anew: how many quads in one, of all and at most; how much longer edges may become, how
// often their vertices are evened out, and how often all are looked for.
constexpr double kOfAll = 0.5;
constexpr size_t kMostInDisk = 400;
constexpr double kLonger = 1.25;
// Sizes: what they went around lies so near to them, at the end and at once; and of what is allowed, what lies so far
// off the surface is not worse than before.
struct DiskLimits {
  double away, atOnce, off;
};
constexpr DiskLimits kNear{0.7, 1, 1.3}, kRegular{1, 1.5, 2};
constexpr int kEvened = 6, kRefills = 6;
// How far the middle of an edge or of a quad may lie off the surface, of its length; the next one where no collapse is
// left with the one before.
constexpr double kBulges[] = {0.2, 0.3, 0.45, 1e9};

class Coarsener {
 public:
  Coarsener(QuadMesh fine, const TriangleMesh& surface, const NearestTriangle& tree, const CreaseMap& creases,
            const std::vector<float>& sizes, double finest, bool regular = false)
      : web_(std::move(fine)),
        surface_(surface),
        tree_(tree),
        creases_(creases),
        sizes_(sizes),
        finest_(finest),
        limits_(regular ? kRegular : kNear),
        changed_(web_.quads(), 0),
        near_(web_.quads(), kNoneNear),
        least_(sizes.empty() ? 0 : double(*std::min_element(sizes.begin(), sizes.end()))) {
    keepFor(web_.vertices());
    std::vector<Vec3d> beside(web_.vertices());  // the surface, as a coarser grid has it
    for (uint32_t v = 0; v < web_.vertices(); ++v) beside[v] = web_.at(v), place(v, web_.at(v));
    placeCorners(beside);
    // Of a crumb all of them may have come to one place.
    for (uint32_t v = 0; v < web_.vertices(); ++v) {
      web_.beside(v, beside_);
      if (shortestAt(v) < kLeastMade * finest_ && !web_.isOnCrease(v)) web_.move(v, beside[v]);
    }
  }

  QuadMesh run(size_t most, const WorkPart& part) {
    if (!creases_.empty())
      for (int round = 0; round < kAtFirst; ++round) makeEven();
    for (uint32_t f = 0; f < web_.quads(); ++f) offer(f);
    const size_t first = web_.count();
    size_t done = 0, doneBefore = 0;
    while (web_.count() > most) {
      if (!last_ && double(web_.count()) < kLastShare * double(most)) {
        last_ = true;
        offerAll();
      }
      if (queue_.empty()) {
        // What was refused may go once its surroundings have moved; where nothing went any more, be content with less.
        if (done == doneBefore && ++stage_ == std::size(kBulges)) break;
        doneBefore = done;
        makeEven();
        offerAll();
        continue;
      }
      const Offer best = queue_.top();
      queue_.pop();
      if (!web_.isThere(best.quad) || changed_[best.quad] != best.changed) continue;
      if (!collapse(best.quad, best.corner)) continue;
      if (++done % kStepEach == 0) part.step(double(first - web_.count()) / double(first - most));
    }
    for (uint32_t f = 0; f < web_.quads(); ++f)
      if (web_.isThere(f)) (void)web_.removeInset(f);
    last_ = true;
    refill(most, part);
    for (int round = 0; round < kAtTheEnd; ++round) {
      if (round == kAtTheEnd / 2) cutCorners();  // where no turn of an edge gave one a second quad
      makeEven();
      if (round >= kAtTheEnd / 2)
        for (uint32_t v = 0; v < web_.vertices(); ++v) unfold(v);
    }
    return web_.mesh();
  }

  QuadMesh evened(const WorkPart& part) {
    for (int round = 0; round < kOfHalved; ++round) {
      part.step(double(round) / kOfHalved);
      for (uint32_t v = 0; v < web_.vertices(); ++v) relax(v);
    }
    for (uint32_t v = 0; v < web_.vertices(); ++v) unfold(v);
    return web_.mesh();
  }

 private:
  struct Offer {
    double cost;
    uint32_t quad, changed;
    int corner;
    bool operator<(const Offer& other) const {
      return cost != other.cost ? cost > other.cost : quad != other.quad ? quad > other.quad : corner > other.corner;
    }
  };

  void keepFor(size_t vertices, uint32_t hint = UINT32_MAX) {
    hints_.resize(vertices, hint);
    creaseHints_.resize(vertices, UINT32_MAX);
    size_.resize(vertices, 0);
    normals_.resize(vertices, Vec3d::Zero());
  }

  // Onto the surface, or along its crease; what ends one stays.
  void place(uint32_t v, const Vec3d& p) {
    if (web_.isOnCrease(v)) {
      if (!web_.isCorner(v)) {
        const CreaseMap::Hit hit = creases_.nearest(p, creaseHints_[v]);
        // In a gap that was bridged there is none.
        const double near = std::max(2 * finest_, kNearCrease * size_[v]);
        if (hit.squared < near * near || isOnLine(v)) return placeAt(v, hit.mm);
      } else if (size_[v] > 0) {
        return placeAt(v, web_.at(v));
      }
    }
    placeOnSurface(v, p);
  }
  bool isOnLine(uint32_t v) {
    return creases_.nearest(web_.at(v), creaseHints_[v]).squared < kLeastMade * kLeastMade * finest_ * finest_;
  }
  void placeAt(uint32_t v, const Vec3d& p) {
    placeOnSurface(v, p);
    web_.move(v, p);
    Vec3d sum = Vec3d::Zero();
    for (const uint32_t f : web_.around(v)) {
      const auto& q = web_.quad(f);
      sum += (web_.at(q[2]) - web_.at(q[0])).cross(web_.at(q[3]) - web_.at(q[1])).normalized();
    }
    if (sum.squaredNorm() > 0) normals_[v] = sum.normalized();
  }
  void placeOnSurface(uint32_t v, const Vec3d& p) {
    const NearestTriangle::Hit hit = tree_.nearest(p, hints_[v]);
    hints_[v] = hit.triangle;
    const auto& c = tree_.corners(hit.triangle);
    const Vec3d &x = surface_.positions[c[0]], &y = surface_.positions[c[1]], &z = surface_.positions[c[2]];
    web_.move(v, nearestOnTriangle(p, x, y, z));
    size_[v] = sizeOf(hit);
    const Vec3d n = (y - x).cross(z - x);
    if (n.squaredNorm() > 0) normals_[v] = n.normalized();
  }

  // `before`: where the vertices of lines were. Corners of the clay, each at the nearest vertex of a line; where
  // creases meet at one where lines do, if there is one near by.
  void placeCorners(const std::vector<Vec3d>& before) {
    std::vector<std::tuple<double, uint32_t, uint32_t>> pairs;  // distance, vertex, corner
    for (uint32_t v = 0; v < web_.vertices(); ++v) {
      if (!web_.isOnCrease(v)) continue;
      web_.alongCreases(v, pulling_);
      double length = 0;
      for (const uint32_t each : pulling_) length += (web_.at(each) - web_.at(v)).norm() / double(pulling_.size());
      for (uint32_t k = 0; k < creases_.corners().size(); ++k)
        if (const double away = (creases_.corners()[k] - web_.at(v)).norm(); away < kCornerNear * length)
          pairs.emplace_back(k < creases_.meetings() && pulling_.size() < 3 ? away + kUnlike * length : away, v, k);
    }
    std::sort(pairs.begin(), pairs.end());
    std::vector<bool> placed(web_.vertices()), taken(creases_.corners().size());
    for (const auto& [away, vertex, corner] : pairs) {
      if (placed[vertex] || taken[corner]) continue;
      placed[vertex] = taken[corner] = true;
      web_.markCorner(vertex);
      placeAt(vertex, creases_.corners()[corner]);
    }
    // Lines that meet elsewhere: two such may be one corner of the clay, so they stay apart as they are.
    for (uint32_t v = 0; v < web_.vertices(); ++v)
      if (web_.isCorner(v) && !placed[v]) placeAt(v, before[v]);
  }

  double sizeOf(const NearestTriangle::Hit& hit) const {
    const auto& c = tree_.corners(hit.triangle);
    return (double(sizes_[c[0]]) + double(sizes_[c[1]]) + double(sizes_[c[2]])) / 3;
  }
  double sizeBetween(uint32_t a, uint32_t b) const { return 0.5 * (size_[a] + size_[b]); }

  void offer(uint32_t f) {
    const auto& q = web_.quad(f);
    for (int corner = 0; corner < 2; ++corner) {
      const uint32_t a = q[size_t(corner)], c = q[size_t(corner) + 2];
      const std::optional<int> gain = web_.gainOfCollapse(f, corner, last_);
      if (!gain) continue;
      double length = (web_.at(a) - web_.at(c)).norm() / sizeBetween(a, c);
      if (web_.isOnCrease(a) && web_.isOnCrease(c)) length *= kOfLine;
      queue_.push({length * std::max(kLeastFactor, 1 - kUneven * *gain), f, changed_[f], corner});
    }
  }

  void offerAll() {
    for (uint32_t f = 0; f < web_.quads(); ++f)
      if (web_.isThere(f)) ++changed_[f], offer(f);
  }

  // No quad keeps a corner that is half a turn: a line leaves it out.
  void cutCorners() {
    const size_t stage = std::exchange(stage_, std::size(kBulges) - 1);  // wherever the line lies then
    for (uint32_t f = 0; f < web_.quads(); ++f)
      for (int corner = 0; corner < 2 && web_.isThere(f); ++corner) {
        const auto& q = web_.quad(f);
        const uint32_t from = q[size_t(corner)], to = q[size_t(corner) + 2];
        const double length = (web_.at(from) - web_.at(to)).norm();
        if (web_.isOnCrease(from) && web_.isOnCrease(to) && length < kLongestCut * sizeBetween(from, to))
          collapse(f, corner);
      }
    stage_ = stage;
  }
  void makeEven() {
    for (uint32_t v = 0; v < web_.vertices(); ++v)
      if (!web_.around(v).empty()) relax(v);
    for (uint32_t v = 0; v < web_.vertices(); ++v)
      if (!web_.around(v).empty()) turnAround(v);
  }

  // The least scaled Jacobian of what v moves: of its own corners of the quads around it and those beside them. 1: a
  // right angle that faces outwards, at a crease as its quad does; below 0: folded.
  double shapeAt(uint32_t v) const {
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
  double off(const Vec3d& p, double length, uint32_t& hint) const {
    if (stage_ + 1 >= std::size(kBulges)) return 0;
    const auto allowed = [&](double size) { return std::max(finest_, kBulges[stage_] * std::min(length, 2 * size)); };
    if (hint != UINT32_MAX && std::sqrt(tree_.squaredTo(hint, p)) <= allowed(least_)) return 0;
    const NearestTriangle::Hit hit = tree_.nearest(p, hint);
    hint = hit.triangle;
    return std::sqrt(hit.squared) / allowed(sizeOf(hit));
  }
  double edgeOff(const Vec3d& p, const Vec3d& q, uint32_t& hint) const {
    return off(0.5 * (p + q), (p - q).norm(), hint);
  }
  // The most of the middles of edges and quads around a vertex, if it were at `to`; but for quad `without`.
  double offAround(uint32_t v, const Vec3d& to, uint32_t without = UINT32_MAX) const {
    double most = 0;
    for (const uint32_t each : web_.around(v)) {
      if (each == without) continue;
      const auto& q = web_.quad(each);
      const auto s = size_t(std::find(q.begin(), q.end(), v) - q.begin());
      Near& near = near_[each];
      for (const size_t place : {s, size_t{4}})
        if (near[place] == UINT32_MAX) near[place] = hints_[v];
      const Vec3d &next = web_.at(q[(s + 1) & 3]), &far = web_.at(q[(s + 2) & 3]), &last = web_.at(q[(s + 3) & 3]);
      most =
          std::max({most, edgeOff(to, next, near[s]),
                    off(0.25 * (to + next + far + last), 0.5 * ((to - far).norm() + (next - last).norm()), near[4])});
    }
    return most;
  }

  bool collapse(uint32_t f, int corner) {
    if (!web_.gainOfCollapse(f, corner)) return false;
    const auto q = web_.quad(f);
    const uint32_t a = q[size_t(corner)], c = q[(size_t(corner) + 2) & 3];
    // On a crease the one that lies there stays where it is; a line that leaves a corner of the quad out goes on from
    // there.
    const bool onA = web_.isOnCrease(a), onC = web_.isOnCrease(c);
    uint32_t cut = UINT32_MAX;
    Vec3d to;
    if (onA && onC) {
      const int bits = web_.creases(f);
      const bool first = (bits >> corner & 1) != 0 && (bits >> ((corner + 1) & 3) & 1) != 0;
      cut = q[size_t(corner + (first ? 1 : 3)) & 3];
      to = web_.isCorner(a) ? web_.at(a) : web_.isCorner(c) ? web_.at(c) : web_.at(cut);
    } else if (onA || onC) {
      to = web_.at(onA ? a : c);
    } else {
      const Vec3d middle = 0.5 * (web_.at(a) + web_.at(c));
      const NearestTriangle::Hit hit = tree_.nearest(middle, hints_[a]);
      const auto& t = tree_.corners(hit.triangle);
      to = nearestOnTriangle(middle, surface_.positions[t[0]], surface_.positions[t[1]], surface_.positions[t[2]]);
    }
    if (offAround(a, to, f) > 1 || offAround(c, to, f) > 1) return false;
    for (const uint32_t end : {a, c}) {
      web_.beside(end, beside_);
      for (const uint32_t each : beside_)
        if (each != cut && (web_.at(each) - to).norm() < kLeastMade * finest_) return false;
    }
    const uint32_t v = web_.collapse(f, corner);
    if (onA || onC)
      placeAt(v, to);
    else
      place(v, to);
    if (cut != UINT32_MAX && !web_.around(cut).empty()) {
      Vec3d sum = Vec3d::Zero();
      web_.beside(cut, beside_);
      for (const uint32_t each : beside_) sum += web_.at(each);
      placeOnSurface(cut, sum / double(beside_.size()));
    }
    relax(v);
    web_.beside(v, ring_);
    const std::vector<uint32_t> ring = ring_;
    for (const uint32_t each : ring)
      if (!web_.around(each).empty()) relax(each);
    turnAround(v);
    touch(v);
    for (const uint32_t each : ring)
      if (!web_.around(each).empty()) touch(each);
    return true;
  }

  // Of the edges to what was put into `beside_`.
  double shortestAt(uint32_t v) const {
    double shortest = INFINITY;
    for (const uint32_t each : beside_) shortest = std::min(shortest, (web_.at(each) - web_.at(v)).norm());
    return shortest;
  }

  // Where each of the two lines of edges through v has it between its ends. The mean of all four ends would draw a row
  // of vertices beside a curved crease onto it: the row's own ends lie on the inner side.
  Vec3d alongLines(uint32_t v) const {
    Vec3d to = web_.at(v);
    for (const auto& [a, c] : web_.linesThrough(v)) {
      const double ha = sizeBetween(v, a), hc = sizeBetween(v, c);
      const Vec3d way = (web_.at(c) - web_.at(a)).normalized();
      const Vec3d middle = (hc * hc * web_.at(a) + ha * ha * web_.at(c)) / (ha * ha + hc * hc);
      to += (middle - web_.at(v)).dot(way) * way;
    }
    return to;
  }

  // Edges of one length in proportion to the sizes pull by as much.
  void relax(uint32_t v) {
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
    // What folds a quad, draws one through the clay, or lets a body of few quads shrink to a point, does not stay.
    bool worse =
        shapeAt(v) < std::min(before, kLeastJacobian) || shortestAt(v) < std::min(shortest, kLeastEdge * finest_);
    if (const double now = worse ? 0 : offAround(v, web_.at(v)); now > 1) worse = now > offAround(v, was);
    if (worse) {
      web_.move(v, was);
      normals_[v] = normal;
      size_[v] = size;
    }
  }

  // A quad with a corner that bends inwards folds, and so does every smooth face over it: v goes where the worst corner
  // around it is best, if there is such a place: towards what is beside it, or away from it.
  void unfold(uint32_t v) {
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
    const double shortest = std::min(shortestAt(v), kLeastEdge * finest_);
    for (const Vec3d& towards : places)
      for (const double share : {0.5, 1.0, -0.5}) {
        place(v, was + share * (towards - was));
        if (shapeAt(v) < most + kBetter || shortestAt(v) < shortest || offAround(v, web_.at(v)) > offBefore) continue;
        most = shapeAt(v);
        best = web_.at(v);
      }
    place(v, best);
  }

  // Disks that would have fewer vertices of other than four quads are filled anew, where the shape of quads, what lies
  // off the surface and the lengths of edges allow it.
  void refill(size_t most, const WorkPart& part) {
    const size_t stage = std::exchange(stage_, 0);
    QuadPatches patches(web_);
    for (int round = 0, changed = 1; round < kRefills && changed > 0; ++round) {
      changed = 0;
      std::set<std::vector<uint32_t>> tried;
      for (uint32_t v = 0; v < web_.vertices(); ++v) {
        part.step(1);
        const auto largest = std::min(kMostInDisk, static_cast<size_t>(kOfAll * double(web_.count())));
        changed += patches.around(v, largest, [&](const Refill& each) {
          return web_.count() + each.fill.quads.size() <= most + each.quads.size() && tried.insert(each.quads).second &&
                 refilled(each);
        });
      }
    }
    stage_ = stage;
  }
  struct Judged {
    double jacobian = 1, off, longest = 0;
    int folded = 0;
  };
  Judged judged(const std::vector<uint32_t>& vertices) {
    Judged out{.off = limits_.off};
    for (const uint32_t v : vertices) {
      const double jacobian = shapeAt(v);
      out.jacobian = std::min(out.jacobian, jacobian);
      out.folded += jacobian < kLeastJacobian;
      out.off = std::max(out.off, offAround(v, web_.at(v)));
      web_.beside(v, beside_);
      for (const uint32_t each : beside_)
        out.longest = std::max(out.longest, (web_.at(v) - web_.at(each)).norm() / sizeBetween(v, each));
    }
    return out;
  }
  std::vector<uint32_t> verticesOf(const std::vector<uint32_t>& quads) const {
    std::vector<uint32_t> all;
    for (const uint32_t f : quads) all.insert(all.end(), web_.quad(f).begin(), web_.quad(f).end());
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }
  // Whether each vertex that was there lies so near to quads, in sizes, that no tip of a limb is left out.
  struct Place {
    uint32_t vertex;
    Vec3d at, normal;
    double size;
  };
  template <class At>
  static bool goAround(const std::vector<std::array<uint32_t, 4>>& quads, const At& at,
                       const std::vector<Place>& places, double sizes) {
    return std::all_of(places.begin(), places.end(), [&](const Place& place) {
      const double near = sizes * place.size;
      return std::any_of(quads.begin(), quads.end(), [&](const auto& q) {
        const std::array<Vec3d, 4> p{at(q[0]), at(q[1]), at(q[2]), at(q[3])};
        return (nearestOnTriangle(place.at, p[0], p[1], p[2]) - place.at).squaredNorm() < near * near ||
               (nearestOnTriangle(place.at, p[0], p[2], p[3]) - place.at).squaredNorm() < near * near;
      });
    });
  }
  bool refilled(const Refill& refill) {
    const std::vector<uint32_t> before = verticesOf(refill.quads);
    std::vector<Place> places;
    for (const uint32_t v : before) places.push_back({v, web_.at(v), normals_[v], size_[v]});
    // The cheapest look first: most cannot be.
    const auto filledAt = [&](uint32_t v) {
      return v < QuadFill::kAdded ? web_.at(v) : refill.fill.added[v - QuadFill::kAdded];
    };
    if (!goAround(refill.fill.quads, filledAt, places, limits_.atOnce)) return false;
    const Judged was = judged(before);
    std::vector<std::array<uint32_t, 4>> old, made = refill.fill.quads;
    for (const uint32_t f : refill.quads) old.push_back(web_.quad(f));
    const auto first = static_cast<uint32_t>(web_.vertices());
    for (const Vec3d& p : refill.fill.added) (void)web_.add(p);
    keepFor(web_.vertices(), hints_[before.front()]);
    for (auto& quad : made)
      for (uint32_t& v : quad)
        if (v >= QuadFill::kAdded) v = v - QuadFill::kAdded + first;
    const std::vector<uint32_t> quads = web_.replace(refill.quads, made, refill.quads);
    changed_.resize(web_.quads(), 0);
    near_.resize(web_.quads(), kNoneNear);
    for (uint32_t v = first; v < web_.vertices(); ++v) placeOnSurface(v, web_.at(v));
    const std::vector<uint32_t> after = verticesOf(quads);
    for (int round = 0; round < kEvened; ++round)
      for (const uint32_t v : after) relax(v);
    for (const uint32_t v : after) unfold(v);
    const Judged is = judged(after);
    const auto at = [&](uint32_t v) { return web_.at(v); };
    if (is.jacobian >= std::min(was.jacobian, kGoodJacobian) && is.folded <= was.folded && is.off <= was.off &&
        is.longest <= kLonger * was.longest && goAround(made, at, places, limits_.away))
      return true;
    (void)web_.replace(quads, old, refill.quads);
    web_.takeBack(first);
    keepFor(first);
    for (const Place& each : places) {
      web_.move(each.vertex, each.at);
      normals_[each.vertex] = each.normal;
      size_[each.vertex] = each.size;
    }
    return false;
  }

  // Edges at v turn as long as that brings four quads to more vertices.
  void turnAround(uint32_t v) {
    for (bool again = true; again;) {
      again = false;
      for (const uint32_t f : web_.around(v)) {
        const auto& q = web_.quad(f);
        const auto s = int(std::find(q.begin(), q.end(), v) - q.begin());
        for (const int step : {1, -1}) {
          const std::optional<int> gain = web_.gainOfTurn(f, s, step, last_);
          if (!gain || *gain <= 0) continue;
          const std::array<uint32_t, 2> ends = web_.endsOfTurn(f, s, step);
          const Vec3d &from = web_.at(ends[0]), &to = web_.at(ends[1]);
          uint32_t hint = hints_[ends[0]];
          if ((from - to).norm() < kLeastMade * finest_ || edgeOff(from, to, hint) > 1) continue;
          web_.turn(f, s, step);
          again = true;
          break;
        }
        if (again) break;
      }
    }
  }

  void touch(uint32_t v) {
    for (const uint32_t f : web_.around(v)) {
      ++changed_[f];
      offer(f);
    }
  }

  QuadWeb web_;
  const TriangleMesh& surface_;
  const NearestTriangle& tree_;
  const CreaseMap& creases_;
  const std::vector<float>& sizes_;
  double finest_;
  DiskLimits limits_;
  size_t stage_ = 0;
  bool last_ = false;
  std::vector<uint32_t> hints_, creaseHints_;
  std::vector<double> size_;
  std::vector<Vec3d> normals_;
  std::vector<uint32_t> changed_;
  // Of each quad: triangles near the middles of its edges, by the corner that they begin at, and near its own.
  using Near = std::array<uint32_t, 5>;
  static constexpr Near kNoneNear{UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX, UINT32_MAX};
  mutable std::vector<Near> near_;
  double least_;  // of the sizes
  std::vector<uint32_t> beside_, ring_, pulling_;
  std::priority_queue<Offer> queue_;
};

}  // namespace

QuadMesh coarsened(QuadMesh fine, const TriangleMesh& surface, const NearestTriangle& tree, const CreaseMap& creases,
                   const std::vector<float>& sizes, size_t most, double finest, const WorkPart& part, bool regular) {
  return Coarsener(std::move(fine), surface, tree, creases, sizes, finest, regular).run(most, part);
}

QuadMesh evenedOut(QuadMesh mesh, const TriangleMesh& surface, const NearestTriangle& tree, const CreaseMap& creases,
                   const std::vector<float>& sizes, double finest, const WorkPart& part) {
  return Coarsener(std::move(mesh), surface, tree, creases, sizes, finest).evened(part);
}

}  // namespace argil::clay
