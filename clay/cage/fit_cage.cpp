#include "clay/cage/fit_cage.h"

#include <algorithm>
#include <cmath>

#include "clay/cage/net_fit.h"
#include "clay/surface/surface.h"

namespace argil::clay {

namespace {

constexpr int kTries = 3;  // cages
constexpr int kTryRounds = 2, kRounds = 4;
constexpr int kTrySpan = 2, kPerSpan = 4;  // places along a span that deviations are taken at
constexpr double kMostOfMost = 3;          // an outlier may be so many times as far as 99 of 100 places

double scoreOf(const PatchDeviation& deviation) {
  double score = 0;
  for (const OneWay& way : {deviation.fromPatches, deviation.fromClay})
    score = std::max({score, way.p99, way.max / kMostOfMost});
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
  return off;
}

}  // namespace

FittedPatches fitPatches(const Version& version, size_t most, int threads, const WorkPart& part) {
  CageMaker maker(version, most, threads, part.part(0, 0.1));
  FittedPatches result;
  double best = INFINITY;
  for (int i = 0; i < kTries; ++i) {
    const WorkPart own = part.part(0.1 + 0.17 * i, 0.27 + 0.17 * i);
    CoarseCage cage = maker.make(own.part(0, 0.3));
    const PatchSurface surface =
        fittedNet(cage.mesh, maker.surface(), maker.tree(), kTryRounds, threads, own.part(0.3, 0.8));
    const double score = scoreOf(deviationOf(surface, maker.surface(), kTrySpan, threads, own.part(0.8, 0.9)));
    if (score < best) {
      best = score;
      result.cage = std::move(cage);
    }
    if (i + 1 < kTries) maker.refine(offOf(maker, surface));
    own.step(1);
  }
  result.irregular = QuadTopology(result.cage.mesh.positions.size(), result.cage.mesh.quads).irregular();
  Surface fine(false, Grade::fine);
  fine.update(version, threads);
  const TriangleMesh clay = fine.toMesh();
  const NearestTriangle tree(clay);
  result.surface = fittedNet(result.cage.mesh, clay, tree, kRounds, threads, part.part(0.6, 0.9));
  result.deviation = deviationOf(result.surface, clay, kPerSpan, threads, part.part(0.9, 1));
  return result;
}

}  // namespace argil::clay
