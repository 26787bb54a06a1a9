#include "clay/cage/fit_cage.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <iterator>
#include <optional>
#include <utility>
#include <vector>

#include "clay/base/error.h"
#include "clay/cage/net_fit.h"
#include "clay/surface/surface.h"

namespace argil::clay {

namespace {

constexpr int kTries = 3, kMostTries = 6;  // cages: more as long as all of them fold somewhere
constexpr float kFoldOff = 8;              // a fold counts as so many times what patches lie off on average
constexpr double kFoldedAllOver = 10;      // and so many more times where the count of folds ends
constexpr FitEffort kTry{2, 6, 6, 0}, kInFull{4, 8, 12, 10};
constexpr size_t kMostFits = 3;            // in full, as long as all of them fold;
constexpr double kWorthFit = 4;            // of cages whose tries cost up to so many times the least
constexpr int kTrySpan = 2, kPerSpan = 8;  // places along a span that deviations are taken at
// Of fitPatchesWithin(): where it begins, how far it goes from try to try, and how much fewer are worth another.
constexpr size_t kFirstQuads = 500, kFewestQuads = 24, kMostCounts = 6;
constexpr double kLeastStep = 1.25, kMostStep = 4;
constexpr double kMostOfMost = 3;  // an outlier may be so many times as far as 99 of 100 places

// Adds the time until it goes to a sum.
class Timed {
 public:
  explicit Timed(double& sum) : sum_(sum) {}
  ~Timed() { sum_ += std::chrono::duration<double>(std::chrono::steady_clock::now() - begin_).count(); }
  Timed(const Timed&) = delete;
  Timed& operator=(const Timed&) = delete;

 private:
  double& sum_;
  std::chrono::steady_clock::time_point begin_ = std::chrono::steady_clock::now();
};
template <class Work>
auto timed(double& sum, const Work& work) {
  const Timed here(sum);
  return work();
}

double scoreOf(const PatchDeviation& deviation) {
  double score = 0;
  for (const OneWay& way : {deviation.fromPatches, deviation.fromClay})
    score = !std::isfinite(way.rms) ? HUGE_VAL : std::max({score, way.p99, way.max / kMostOfMost});
  return score;
}

// How far vertices of the clay lie off the patches, and places of the patches off the clay, at the vertices near them.
std::vector<float> offOf(const CageMaker& maker, const PatchSurface& surface) {
  const TriangleMesh patches = meshOf(surface, kTrySpan);
  const NearestTriangle tree(patches);
  std::vector<float> off(maker.surface().positions.size(), 0);
  uint32_t hint = UINT32_MAX;
  for (size_t i = 0; i < off.size(); ++i) {
    const NearestTriangle::Hit hit = tree.nearest(maker.surface().positions[i], hint);
    hint = hit.triangle;
    off[i] = static_cast<float>(std::sqrt(hit.squared));
  }
  hint = UINT32_MAX;
  for (const Vec3d& each : patches.positions) {
    const NearestTriangle::Hit hit = maker.tree().nearest(each, hint);
    hint = hit.triangle;
    for (const uint32_t v : maker.tree().corners(hit.triangle))
      off[v] = std::max(off[v], static_cast<float>(std::sqrt(hit.squared)));
  }
  double sum = 0;
  for (const float each : off) sum += double(each) * double(each);
  const float fold = kFoldOff * static_cast<float>(std::sqrt(sum / double(off.size())));
  for (const uint32_t place : foldsOf(surface, patches, kTrySpan))
    for (const uint32_t v : maker.tree().corners(maker.tree().nearest(patches.positions[place], UINT32_MAX).triangle))
      off[v] = std::max(off[v], fold);
  return off;
}

// Folds weigh as well as distances; where no end of them is seen, most of all.
double costOf(const PatchDeviation& deviation) {
  const size_t folds = deviation.foldsMm.size();
  return scoreOf(deviation) * (1 + double(folds)) * (folds < kMostFarPlaces ? 1 : kFoldedAllOver);
}

bool hasCreases(const QuadMesh& mesh) {
  return std::any_of(mesh.creases.begin(), mesh.creases.end(), [](uint8_t bits) { return bits != 0; });
}

// Cages that were fitted for a try, the best first.
struct TriedCages {
  struct Tried {
    CoarseCage cage;
    double cost = INFINITY;
    size_t folds = 0;
    WishesMet met;
  };
  std::vector<Tried> cages;
  FitTimes& times;

  [[nodiscard]] bool none() const { return cages.empty(); }
  // Throws where no cage is possible; with `elsewhere`, one of another kind, it is content with none.
  void take(bool elsewhere, CageMaker& maker, int tries, int mostTries, int threads, const WorkPart& part) {
    try {
      take(maker, tries, mostTries, threads, part);
    } catch (const Cancelled&) {
      throw;
    } catch (const Error&) {
      if (!elsewhere) throw;
    }
    sort();
  }
  void sort() {
    std::stable_sort(cages.begin(), cages.end(), [](const Tried& a, const Tried& b) { return a.cost < b.cost; });
  }

 private:
  void take(CageMaker& maker, int tries, int mostTries, int threads, const WorkPart& part) {
    bool folded = true;
    for (int i = 0; i < tries || (i < mostTries && folded); ++i) {
      const int left = i < tries ? tries : mostTries;
      const WorkPart own = part.part(double(i) / left, double(i + 1) / left);
      CoarseCage made = timed(times.cages, [&] { return maker.make(own.part(0, 0.3)); });
      const WishesMet met = timed(times.cages, [&] { return maker.settle(made.mesh); });
      const PatchSurface surface = timed(times.fits, [&] {
        return fittedNet(made.mesh, maker.surface(), maker.tree(), maker.creases(), kTry, threads, own.part(0.3, 0.8));
      });
      const PatchDeviation deviation = timed(times.measuring, [&] {
        return deviationOf(surface, maker.surface(), kTrySpan, threads, own.part(0.8, 0.9));
      });
      folded = folded && !deviation.foldsMm.empty();
      cages.push_back({std::move(made), costOf(deviation), deviation.foldsMm.size(), met});
      maker.refine(timed(times.measuring, [&] { return offOf(maker, surface); }));
      own.step(1);
    }
  }
};

FittedPatches fitted(const Version& version, size_t most, double limitMm, int threads, const WorkPart& part,
                     const CageWishes& wishes) {
  FittedPatches result;
  FitTimes times;
  TriedCages tried{{}, times};
  CageMaker maker =
      timed(times.cages, [&] { return CageMaker(version, most, true, threads, part.part(0, 0.05), {}, wishes); });
  const bool creased = !maker.creases().empty();
  tried.take(creased, maker, kTries, kMostTries, threads, part.part(0.05, creased ? 0.45 : 0.6));
  if (creased &&
      (tried.none() || !std::isfinite(tried.cages.front().cost) || tried.cages.front().folds >= kMostFarPlaces)) {
    // Creases that cannot be drawn without folds wherever one looks are rounded.
    CageMaker smooth =
        timed(times.cages, [&] { return CageMaker(version, most, false, threads, part.part(0.45, 0.5), {}, wishes); });
    TriedCages others{{}, times};
    others.take(!tried.none(), smooth, kTries, kTries, threads, part.part(0.5, 0.6));
    std::move(others.cages.begin(), others.cages.end(), std::back_inserter(tried.cages));
    tried.sort();
  }
  // The fine grade: what the cages with creases were drawn around already.
  TriangleMesh fine;
  std::optional<NearestTriangle> fineTree;
  if (maker.grade() != Grade::fine) {
    Surface surface(false, Grade::fine);
    surface.update(version, threads);
    fine = surface.toMesh();
    fineTree.emplace(fine);
  }
  const TriangleMesh& clay = fineTree ? fine : maker.surface();
  const NearestTriangle& tree = fineTree ? *fineTree : maker.tree();
  // A try says roughly what a cage is good for: as long as patches fold the next one is fitted in full as well.
  double least = INFINITY;
  for (size_t i = 0; i < std::min(kMostFits, tried.cages.size()); ++i) {
    TriedCages::Tried& each = tried.cages[i];
    if (i > 0 && (result.deviation.foldsMm.empty() || each.cost > kWorthFit * tried.cages.front().cost)) break;
    // Creases are not given up for a fold.
    if (i > 0 && hasCreases(result.cage.mesh) && !hasCreases(each.cage.mesh)) continue;
    const WorkPart own = part.part(1 - 0.4 / double(1 << i), 1 - 0.2 / double(1 << i));
    PatchSurface surface = timed(times.fits, [&] {
      return fittedNet(each.cage.mesh, clay, tree, maker.creases(), kInFull, threads, own.part(0, 0.75));
    });
    PatchDeviation deviation = timed(
        times.measuring, [&] { return deviationOf(surface, clay, kPerSpan, threads, own.part(0.75, 1), limitMm); });
    const double cost = costOf(deviation);
    if (i > 0 && !(cost < least)) continue;
    least = cost;
    result.irregular = QuadTopology(each.cage.mesh).irregular();
    result.cage = std::move(each.cage);
    result.met = each.met;
    result.surface = std::move(surface);
    result.deviation = std::move(deviation);
  }
  result.times = times;
  part.step(1);
  return result;
}

}  // namespace

FittedPatches fitPatches(const Version& version, size_t most, int threads, const WorkPart& part,
                         const CageWishes& wishes) {
  return fitted(version, most, HUGE_VAL, threads, part, wishes);
}

// The farthest place comes nearer about as the count of quads grows (NOTES.md, "Within an error"). A step that met the
// error is halved against the last one that did not, as far as it pays.
FittedPatches fitPatchesWithin(const Version& version, double errorMm, size_t most, int threads, const WorkPart& part,
                               std::vector<PatchTry>& tries, const CageWishes& wishes) {
  if (!(errorMm > 0) || !std::isfinite(errorMm)) throw Error("the error of patches is a length above zero");
  FittedPatches best;
  FitTimes all;
  double bestMissed = HUGE_VAL;  // above 1: not within
  size_t tooFew = 0;
  for (size_t quads = std::min(kFirstQuads, most), i = 0; i < kMostCounts; ++i) {
    const WorkPart own = part.part(double(i) / kMostCounts, double(i + 1) / kMostCounts);
    size_t next = 0;
    try {
      FittedPatches now = fitted(version, quads, errorMm, threads, own, wishes);
      all.cages += now.times.cages;
      all.fits += now.times.fits;
      all.measuring += now.times.measuring;
      tries.push_back({now.surface.patches.size(), now.deviation.mostMm(), now.deviation.boundMm});
      const double missed = std::max(tries.back().mostMm, tries.back().boundMm) / errorMm;
      // Of those within it the fewest, else the nearest.
      const bool fewer = bestMissed > 1 || now.surface.patches.size() < best.surface.patches.size();
      if (missed <= 1 ? fewer : missed < bestMissed) {
        best = std::move(now);
        bestMissed = missed;
      }
      if (missed > 1)
        tooFew = std::max(tooFew, quads);
      else if (tooFew == 0)
        next = static_cast<size_t>(double(quads) * std::max(missed, 1 / kMostStep));
      if (missed > 1 && bestMissed > 1)
        next = static_cast<size_t>(double(quads) * std::clamp(1.2 * missed, kLeastStep, kMostStep));
    } catch (const Cancelled&) {
      throw;
    } catch (const Error&) {
      // So few that no cage keeps the shape.
      if (quads >= most && tries.empty()) throw;
      tooFew = std::max(tooFew, quads);
      if (bestMissed > 1) next = static_cast<size_t>(double(quads) * kMostStep);
    }
    if (next == 0) next = (tooFew + best.surface.patches.size()) / 2;
    next = std::clamp(next, std::min(kFewestQuads, most), most);
    const bool pays = double(next) * kLeastStep < double(best.surface.patches.size());
    if (next == quads || next <= tooFew || (bestMissed <= 1 && !pays)) break;
    quads = next;
  }
  best.times = all;
  part.step(1);
  return best;
}

}  // namespace argil::clay
