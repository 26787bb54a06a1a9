#include "clay/cage/coarsen_quads.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <queue>
#include <set>
#include <utility>

#include "clay/cage/quad_patches.h"
#include "clay/cage/quad_web.h"
#include "clay/cage/web_on_surface.h"

namespace argil::clay {

namespace {

constexpr double kUneven = 0.2;  // of a diagonal's length: what nearness to four quads a vertex counts
constexpr double kLeastFactor = 0.4;
constexpr int kAtFirst = 3;              // rounds that make edges even, where there are creases
constexpr int kAtTheEnd = 20;            // rounds that make edges even
constexpr double kLeastUnfolded = 0.05;  // sizes: then vertices come no nearer for better corners
constexpr int kOfHalved = 6;             // rounds that make those of halved quads even
constexpr size_t kStepEach = 512;
constexpr double kLastShare = 1.3;  // times the quads that are asked for: from there on lines keep two quads a vertex
constexpr double kLongestCut = 3;   // sizes: two edges of a line that are longer keep what lies between them
constexpr double kOfLine = 0.8;     // what a diagonal beside two edges of a line counts of its length
// Disks of quads that are filled anew: how many quads in one, of all and at most; how much longer edges may become, and
// in sizes; how often their vertices are evened out, and how often all are looked for.
constexpr double kOfAll = 0.5;
constexpr size_t kMostInDisk = 400;
constexpr double kLonger = 1.25;
constexpr double kShort = 0.5;  // sizes: beside a line that gets another count of edges none becomes so short
constexpr double kRoom = 0.97;  // of the quads that are asked for: lines that get more edges take the rest
// Sizes: what they went around lies so near to them, at the end and at once; and of what is allowed, what lies so far
// off the surface is not worse than before.
struct DiskLimits {
  double away, atOnce, off, longest;
};
constexpr DiskLimits kNear{0.7, 1, 1.3, HUGE_VAL}, kRegular{1, 1.5, 2, 2.6};
constexpr size_t kMoreQuads = 2;  // that a quad alone on a side of a line takes not to be alone
constexpr int kEvened = 6, kEvenedBesideLines = 24, kRefills = 6;
// Refills that make sides more alike, and no vertex regular. From another disk the same line may look better as it was,
// and the two would take turns for ever.
constexpr size_t kLevelSteps = 16;

class Coarsener {
 public:
  Coarsener(QuadMesh fine, const WebGround& ground)
      : on_(std::move(fine), ground), ground_(ground), changed_(web().quads(), 0) {}

  /// What is the same whatever comes of it: for at most `most` / kLastShare quads.
  void begin(size_t most, const WorkPart& part) {
    if (!ground_.creases.empty())
      for (int round = 0; round < kAtFirst; ++round) makeEven();
    offerAll();
    goOn(most, WebOnSurface::kStages, false, part);
    forgetGone();
  }

  /// After begin().
  QuadMesh end(size_t most, Coarsening how, const WorkPart& part) {
    limits_ = how.regular ? kRegular : kNear;
    regular_ = how.regular;
    between_ = how.between;
    goOn(regular_ && !ground_.creases.empty() ? static_cast<size_t>(kRoom * double(most)) : most, WebOnSurface::kStages,
         true, part);
    for (uint32_t f = 0; f < web().quads(); ++f)
      if (web().isThere(f)) (void)web().removeInset(f);
    last_ = true;
    refill(most, part);
    // Where hardly so few were possible nothing more is asked.
    if (const size_t more = kMoreQuads * halfTurns().size(); more > 0 && !between_ && on_.stage() == 0) {
      if (web().count() + more > most && more < most) becomeFewer(most - more, 1, part);
      openHalfTurns(most, part);
    }
    for (int round = 0; round < kAtTheEnd; ++round) {
      if (round == kAtTheEnd / 2) {
        cutCorners();  // where no turn of an edge gave one a second quad
        if (!between_ && on_.stage() == 0) openHalfTurns(most, part);
      }
      makeEven();
      if (round >= kAtTheEnd / 2)
        for (uint32_t v = 0; v < web().vertices(); ++v) on_.unfold(v, kLeastUnfolded);
    }
    return web().mesh();
  }

  QuadMesh evened(const WorkPart& part) {
    for (int round = 0; round < kOfHalved; ++round) {
      part.step(double(round) / kOfHalved);
      for (uint32_t v = 0; v < web().vertices(); ++v) on_.relax(v);
    }
    for (uint32_t v = 0; v < web().vertices(); ++v) on_.unfold(v, kLeastUnfolded);
    return web().mesh();
  }

 private:
  void becomeFewer(size_t most, size_t stages, const WorkPart& part) {
    offerAll();
    done_ = doneBefore_ = 0;
    goOn(most, stages, true, part);
  }

  /// `toTheEnd`: not on the way to fewer than that.
  void goOn(size_t most, size_t stages, bool toTheEnd, const WorkPart& part) {
    const size_t first = web().count();
    while (web().count() > most) {
      if (toTheEnd && !last_ && double(web().count()) < kLastShare * double(most)) {
        last_ = true;
        offerAll();
      }
      if (queue_.empty()) {
        // What was refused may go once its surroundings have moved; where nothing went any more, be content with less.
        if (done_ == doneBefore_) {
          if (on_.stage() + 1 >= stages) break;
          on_.setStage(on_.stage() + 1);
        }
        doneBefore_ = done_;
        makeEven();
        offerAll();
        continue;
      }
      const Offer best = queue_.top();
      queue_.pop();
      if (!web().isThere(best.quad) || changed_[best.quad] != best.changed) continue;
      if (!collapse(best.quad, best.corner)) continue;
      if (++done_ % kStepEach == 0) part.step(double(first - web().count()) / double(first - most));
    }
  }

  // Most are gone by then, and the rest is copied for each that goes on from there.
  void forgetGone() {
    std::vector<Offer> offers;
    for (; !queue_.empty(); queue_.pop()) {
      const Offer& each = queue_.top();
      if (web().isThere(each.quad) && changed_[each.quad] == each.changed) offers.push_back(each);
    }
    const std::vector<uint32_t> quads = on_.forgetGone().quads;
    for (Offer& each : offers)
      each.quad = static_cast<uint32_t>(std::lower_bound(quads.begin(), quads.end(), each.quad) - quads.begin());
    queue_ = std::priority_queue<Offer>(std::less<Offer>(), std::move(offers));
    keepOnly(changed_, quads);
  }

  struct Offer {
    double cost;
    uint32_t quad, changed;
    int corner;
    bool operator<(const Offer& other) const {
      return cost != other.cost ? cost > other.cost : quad != other.quad ? quad > other.quad : corner > other.corner;
    }
  };

  void offer(uint32_t f) {
    const auto& q = web().quad(f);
    for (int corner = 0; corner < 2; ++corner) {
      const uint32_t a = q[size_t(corner)], c = q[size_t(corner) + 2];
      const std::optional<int> gain = web().gainOfCollapse(f, corner, last_);
      if (!gain) continue;
      double length = (web().at(a) - web().at(c)).norm() / on_.sizeBetween(a, c);
      if (web().isOnCrease(a) && web().isOnCrease(c)) length *= kOfLine;
      queue_.push({length * std::max(kLeastFactor, 1 - kUneven * *gain), f, changed_[f], corner});
    }
  }

  void offerAll() {
    for (uint32_t f = 0; f < web().quads(); ++f)
      if (web().isThere(f)) ++changed_[f], offer(f);
  }

  // No quad keeps a corner that is half a turn: a line leaves it out.
  void cutCorners() {
    const size_t stage = on_.stage();
    on_.setStage(WebOnSurface::kStages - 1);  // wherever the line lies then
    for (uint32_t f = 0; f < web().quads(); ++f)
      for (int corner = 0; corner < 2 && web().isThere(f); ++corner) {
        const auto& q = web().quad(f);
        const uint32_t from = q[size_t(corner)], to = q[size_t(corner) + 2];
        const double length = (web().at(from) - web().at(to)).norm();
        if (web().isOnCrease(from) && web().isOnCrease(to) && length < kLongestCut * on_.sizeBetween(from, to))
          collapse(f, corner);
      }
    on_.setStage(stage);
  }
  // Corners of quads that are about half a turn, as one line goes along both sides.
  struct HalfTurn {
    uint32_t quad;
    int corner;
  };
  std::vector<HalfTurn> halfTurns() const {
    std::vector<HalfTurn> out;
    for (uint32_t f = 0; f < web().quads(); ++f) {
      if (!web().isThere(f) || web().creases(f) == 0) continue;
      const auto& q = web().quad(f);
      for (int s = 0; s < 4; ++s) {
        const uint32_t v = q[size_t(s)];
        const QuadWeb::Sector at = web().sectorOf(v, f);
        if (at.count != 1 || at.right != 2) continue;
        const Vec3d a = web().at(q[size_t(s + 1) & 3]) - web().at(v), b = web().at(q[size_t(s + 3) & 3]) - web().at(v);
        if (a.cross(b).norm() < WebOnSurface::kGoodJacobian * a.norm() * b.norm()) out.push_back({f, s});
      }
    }
    return out;
  }
  // The vertex gets a second quad on that side; a face that is one quad joins another.
  void openHalfTurns(size_t most, const WorkPart& part) {
    const size_t stage = on_.stage(), before = web().count();
    on_.setStage(0);
    const QuadPatches patches(web());
    for (const HalfTurn& each : halfTurns()) {
      if (!web().isThere(each.quad) || web().joinFace(each.quad, each.corner)) continue;
      std::array ways{patches.notAlone(each.quad, each.corner, true), patches.notAlone(each.quad, each.corner, false)};
      if (ways[0] && ways[1] && ways[1]->gain > ways[0]->gain) std::swap(ways[0], ways[1]);
      if (web().count() + kMoreQuads <= most)
        (void)std::any_of(ways.begin(), ways.end(), [&](const auto& way) { return way && refilled(*way); });
    }
    on_.setStage(stage);
    if (web().count() > before) refill(most, part);
  }

  void makeEven() {
    for (uint32_t v = 0; v < web().vertices(); ++v)
      if (!web().around(v).empty()) on_.relax(v);
    for (uint32_t v = 0; v < web().vertices(); ++v)
      if (!web().around(v).empty()) turnAround(v);
  }

  bool collapse(uint32_t f, int corner) {
    if (!web().gainOfCollapse(f, corner)) return false;
    const auto q = web().quad(f);
    const uint32_t a = q[size_t(corner)], c = q[(size_t(corner) + 2) & 3];
    // On a crease the one that lies there stays where it is; a line that leaves a corner of the quad out goes on from
    // there.
    const bool onA = web().isOnCrease(a), onC = web().isOnCrease(c);
    uint32_t cut = UINT32_MAX;
    Vec3d to;
    if (onA && onC) {
      const int bits = web().creases(f);
      const bool first = (bits >> corner & 1) != 0 && (bits >> ((corner + 1) & 3) & 1) != 0;
      cut = q[size_t(corner + (first ? 1 : 3)) & 3];
      to = web().isCorner(a) ? web().at(a) : web().isCorner(c) ? web().at(c) : web().at(cut);
    } else if (onA || onC) {
      to = web().at(onA ? a : c);
    } else {
      to = on_.onSurface(0.5 * (web().at(a) + web().at(c)), a);
    }
    if (on_.offAround(a, to, f) > 1 || on_.offAround(c, to, f) > 1) return false;
    for (const uint32_t end : {a, c}) {
      web().beside(end, beside_);
      for (const uint32_t each : beside_)
        if (each != cut && (web().at(each) - to).norm() < WebOnSurface::kLeastMade * ground_.finest) return false;
    }
    const uint32_t v = web().collapse(f, corner);
    if (onA || onC)
      on_.placeAt(v, to);
    else
      on_.place(v, to);
    if (cut != UINT32_MAX && !web().around(cut).empty()) {
      Vec3d sum = Vec3d::Zero();
      web().beside(cut, beside_);
      for (const uint32_t each : beside_) sum += web().at(each);
      on_.placeOnSurface(cut, sum / double(beside_.size()));
    }
    on_.relax(v);
    web().beside(v, ring_);
    const std::vector<uint32_t> ring = ring_;
    for (const uint32_t each : ring)
      if (!web().around(each).empty()) on_.relax(each);
    turnAround(v);
    touched_ = web().around(v);
    for (const uint32_t each : ring)
      touched_.insert(touched_.end(), web().around(each).begin(), web().around(each).end());
    std::sort(touched_.begin(), touched_.end());
    touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
    for (const uint32_t each : touched_) ++changed_[each], offer(each);
    return true;
  }

  // Disks that would have fewer vertices of other than four quads are filled anew, where the shape of quads, what lies
  // off the surface and the lengths of edges allow it.
  void refill(size_t most, const WorkPart& part) {
    const size_t stage = on_.stage();
    on_.setStage(0);
    QuadPatches patches(web(), regular_);
    size_t level = 0;
    for (int round = 0, changed = 1; round < kRefills && changed > 0; ++round) {
      changed = 0;
      std::set<std::pair<std::vector<uint32_t>, size_t>> tried;
      for (uint32_t v = 0; v < web().vertices(); ++v) {
        part.step(1);
        const auto largest = std::min(kMostInDisk, static_cast<size_t>(kOfAll * double(web().count())));
        changed += patches.around(v, largest, [&](const Refill& each) {
          const bool isLevel = each.gain <= 0;
          const bool taken = web().count() + each.made.size() <= most + each.quads.size() &&
                             tried.emplace(each.quads, each.lines.empty() ? 0 : each.made.size()).second &&
                             !(isLevel && level == kLevelSteps) && refilled(each);
          level += taken && isLevel;
          return taken;
        });
      }
    }
    on_.setStage(stage);
  }
  struct Judged {
    double jacobian = 1, off, longest = 0, shortest = kShort;
    int folded = 0;
  };
  Judged judged(const std::vector<uint32_t>& vertices) {
    Judged out{.off = limits_.off};
    for (const uint32_t v : vertices) {
      const double jacobian = on_.shapeAt(v);
      out.jacobian = std::min(out.jacobian, jacobian);
      out.folded += jacobian < WebOnSurface::kLeastJacobian;
      out.off = std::max(out.off, on_.offAround(v, web().at(v)));
      web().beside(v, beside_);
      for (const uint32_t each : beside_) {
        const double length = (web().at(v) - web().at(each)).norm() / on_.sizeBetween(v, each);
        out.longest = std::max(out.longest, length);
        out.shortest = std::min(out.shortest, length);
      }
    }
    return out;
  }
  std::vector<uint32_t> verticesOf(const std::vector<uint32_t>& quads) const {
    std::vector<uint32_t> all;
    for (const uint32_t f : quads) all.insert(all.end(), web().quad(f).begin(), web().quad(f).end());
    std::sort(all.begin(), all.end());
    all.erase(std::unique(all.begin(), all.end()), all.end());
    return all;
  }
  // Whether each vertex that was there lies so near to quads, in sizes, that no tip of a limb is left out.
  using Place = WebOnSurface::Place;
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
  bool refilled(Refill refill) {
    if (regular_) refill.carryOver(web());
    const std::vector<uint32_t> before = verticesOf(refill.quads);
    std::vector<Place> places;
    for (const uint32_t v : before) places.push_back(on_.placeOf(v));
    // The cheapest look first: most cannot be.
    const auto filledAt = [&](uint32_t v) {
      return v < QuadFill::kAdded ? web().at(v) : refill.added[v - QuadFill::kAdded];
    };
    if (!goAround(refill.made, filledAt, places, limits_.atOnce)) return false;
    const Judged was = judged(before);
    std::vector<std::array<uint32_t, 4>> old, made = refill.made;
    for (const uint32_t f : refill.quads) old.push_back(web().quad(f));
    const auto first = static_cast<uint32_t>(web().vertices());
    for (const Vec3d& p : refill.added) (void)on_.add(p, before.front());
    std::vector<BorderSide> lines = refill.newLines;
    const auto number = [&](uint32_t& v) {
      if (v >= QuadFill::kAdded) v = v - QuadFill::kAdded + first;
    };
    for (auto& quad : made) std::for_each(quad.begin(), quad.end(), number);
    for (BorderSide& line : lines) std::for_each(line.begin(), line.end(), number);
    const std::vector<uint32_t> quads = on_.replace(refill.quads, made, refill.quads, lines);
    for (const BorderSide& line : lines)
      for (const uint32_t v : line)
        if (v >= first) on_.place(v, web().at(v));
    changed_.resize(web().quads(), 0);
    const std::vector<uint32_t> after = verticesOf(quads);
    for (int round = 0; round < (lines.empty() ? kEvened : kEvenedBesideLines); ++round)
      for (const uint32_t v : after) on_.relax(v);
    for (const uint32_t v : after) on_.unfold(v);
    const Judged is = judged(after);
    const auto at = [&](uint32_t v) { return web().at(v); };
    if (is.jacobian >= std::min(was.jacobian, WebOnSurface::kGoodJacobian) && is.folded <= was.folded &&
        is.off <= was.off && is.longest <= std::max(was.longest, std::min(kLonger * was.longest, limits_.longest)) &&
        (refill.lines.empty() || kLonger * is.shortest >= was.shortest) && goAround(made, at, places, limits_.away))
      return true;
    (void)on_.replace(quads, old, refill.quads, refill.lines);
    on_.takeBack(first);
    for (const Place& each : places) on_.putBack(each);
    return false;
  }

  // Edges at v turn as long as that brings four quads to more vertices.
  void turnAround(uint32_t v) {
    for (bool again = true; again;) {
      again = false;
      for (const uint32_t f : web().around(v)) {
        const auto& q = web().quad(f);
        const auto s = int(std::find(q.begin(), q.end(), v) - q.begin());
        for (const int step : {1, -1}) {
          const std::optional<int> gain = web().gainOfTurn(f, s, step, last_);
          if (!gain || *gain <= 0) continue;
          const std::array<uint32_t, 2> ends = web().endsOfTurn(f, s, step);
          const double length = (web().at(ends[0]) - web().at(ends[1])).norm();
          if (length < WebOnSurface::kLeastMade * ground_.finest || on_.edgeOff(ends[0], ends[1]) > 1) continue;
          web().turn(f, s, step);
          again = true;
          break;
        }
        if (again) break;
      }
    }
  }

  QuadWeb& web() { return on_.web(); }
  [[nodiscard]] const QuadWeb& web() const { return on_.web(); }

  WebOnSurface on_;
  WebGround ground_;
  DiskLimits limits_ = kNear;
  bool regular_ = false, between_ = false, last_ = false;
  size_t done_ = 0, doneBefore_ = 0;  // joins, and those before it was last looked what can go
  std::vector<uint32_t> changed_, beside_, ring_, touched_;
  std::priority_queue<Offer> queue_;
};

}  // namespace

struct SharedCoarsening::State {
  Coarsener begun;
  size_t most;
};

SharedCoarsening::SharedCoarsening(QuadMesh fine, const WebGround& ground, size_t most, const WorkPart& part)
    : state_(std::make_unique<State>(State{Coarsener(std::move(fine), ground), most})) {
  state_->begun.begin(static_cast<size_t>(std::ceil(kLastShare * double(most))), part);
}

SharedCoarsening::~SharedCoarsening() = default;

size_t SharedCoarsening::most() const {
  return state_->most;
}

QuadMesh SharedCoarsening::to(size_t most, const WorkPart& part, Coarsening how) const {
  Coarsener own = state_->begun;
  return own.end(most, how, part);
}

QuadMesh coarsened(QuadMesh fine, const WebGround& ground, size_t most, const WorkPart& part, Coarsening how) {
  Coarsener all(std::move(fine), ground);
  all.begin(static_cast<size_t>(std::ceil(kLastShare * double(most))), part.part(0, 0.5));
  return all.end(most, how, part.part(0.5, 1));
}

QuadMesh evenedOut(QuadMesh mesh, const WebGround& ground, const WorkPart& part) {
  return Coarsener(std::move(mesh), ground).evened(part);
}

}  // namespace argil::clay
