// What clay was said to cost before it was made, beside what it costs.

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "bench/bench.h"
#include "bench/costs.h"
#include "bench/known_shapes.h"
#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "engine/document/cost.h"
#include "engine/document/random.h"

namespace argil::bench {

namespace {

constexpr int kScenes = 20;

struct Scene {
  engine::ClayPlan plan;
  engine::Quality quality;
  bool block = false;
  Ring ring{};
  Vec3d sizeMm = Vec3d::Zero();
};

Scene randomScene(engine::Random& random) {
  Scene scene;
  scene.block = random.unit() < 0.3;
  scene.quality.clay.voxelsAcross = std::exp(random.between(std::log(80), std::log(420)));
  scene.quality.clay.band = 2 + static_cast<double>(random.below(4));
  scene.quality.clay.halfMemory = random.unit() < 0.3;
  // Grooves of many sizes around the ball.
  scene.ring = {"", "carve", random.between(1.5, 5), random.between(19, 21)};
  scene.sizeMm = Vec3d(random.between(25, 40), random.between(25, 40), 40);
  scene.plan.voxelMm = 2 * kBallMm / scene.quality.clay.voxelsAcross;
  scene.plan.band = scene.quality.clay.band;
  if (scene.block) scene.plan.slant = 1;
  scene.plan.precision = scene.quality.clay.precision();
  scene.plan.tipMm = scene.plan.voxelMm * std::exp(random.between(std::log(4), std::log(50)));
  const Vec3d& s = scene.sizeMm;
  scene.plan.areaMm2 =
      scene.block ? 2 * (s.x() * s.y() + s.y() * s.z() + s.z() * s.x()) : 4 * std::numbers::pi * kBallMm * kBallMm;
  return scene;
}

// The median of dabs at places of the ball or the block, each taken back before the next.
double dabMs(const clay::Version& clay, clay::Surface& surface, const Scene& scene, engine::Random& random) {
  static const auto brush = clay::Brush::of(clay::Method::carve);
  Samples samples;
  for (int i = 0; i < 21; ++i) {
    Vec3d way = random.inBall().normalized();
    if (scene.block) {
      const int axis = static_cast<int>(random.below(3));
      way = 0.6 * random.inBall();
      way[axis] = way[axis] < 0 ? -1 : 1;
      way = way.cwiseProduct(0.5 * scene.sizeMm) / kBallMm;
    }
    const Vec3d at = clay.grid().toVoxel(kBallMm * way);
    const Stopwatch watch;
    clay::BrushStroke stroke(clay, brush);
    stroke.apply({at, at, scene.plan.tipMm / scene.plan.voxelMm});
    surface.update(stroke.publish());
    samples.add(watch.us());
    surface.update(clay);
  }
  return 1e-3 * samples.median();
}

}  // namespace

void benchCosts(BenchReport& report, const BenchOptions& options) {
  report.heading("what clay was said to cost, beside what it costs");
  const engine::MachineSpeed machine = engine::measureMachine();
  engine::Random random(11);
  std::vector<double> off[5];
  constexpr const char* kWhat[] = {"voxels", "bytes", "triangles", "dab", "edge"};
  for (int i = 0; i < kScenes; ++i) {
    if (options.job) options.job->step(static_cast<double>(i) / kScenes);
    const Scene scene = randomScene(random);
    const engine::ClayCost said = engine::costOf(scene.plan, machine);
    const clay::Grid grid = gridOf(scene.quality);
    const auto store = clay::Store::make(scene.plan.precision);
    const clay::Version plain = scene.block ? clay::makeBlock(store, grid, Vec3d::Zero(), scene.sizeMm, 1)
                                            : clay::makeSphere(store, grid, Vec3d::Zero(), kBallMm);
    clay::Surface surface(true, clay::Grade::crisp);
    surface.update(plain);
    const double bytes = static_cast<double>(plain.stats().bytes() + surface.usage().bytes);
    double is[5] = {static_cast<double>(plain.activeVoxels()), bytes, 2.0 * static_cast<double>(surface.quadCount()),
                    dabMs(plain, surface, scene, random), 0};
    const double predicted[5] = {said.activeVoxels, said.bytes, said.triangles, said.dabMs, said.edgeMm};
    if (!scene.block) {
      surface.update(ringOn(scene.ring, plain, {}));
      const clay::TriangleMesh mesh = surface.toMesh();
      const clay::NearestTriangle nearest(mesh);
      double squares = 0;
      const std::vector<Vec3d> edges = turnedOf(scene.ring).edges();
      for (const Vec3d& p : edges) squares += nearest.nearest(p).squared;
      is[4] = std::sqrt(squares / static_cast<double>(std::max<size_t>(edges.size(), 1)));
    }
    for (int k = 0; k < 5; ++k) {
      if (is[k] == 0) continue;
      off[k].push_back(predicted[k] / is[k]);
      BenchResult result;
      result.name = fmt::format("costs/{}/{}", i, kWhat[k]);
      result.unit = "×";
      result.median = predicted[k] / is[k];
      result.note =
          fmt::format("said {:.4g}, is {:.4g}; voxels of {:.3g} mm, band {:g}, tip {:.3g} mm, {}", predicted[k], is[k],
                      scene.plan.voxelMm, scene.plan.band, scene.plan.tipMm, scene.block ? "block" : "ball");
      report.keep(result);
      if (std::abs(std::log(result.median)) > std::log(1.25)) report.add(result);
    }
  }
  for (int k = 0; k < 5; ++k) {
    BenchResult result;
    result.name = fmt::format("costs/{}", kWhat[k]);
    result.unit = "×";
    result.n = off[k].size();
    const auto [least, most] = std::minmax_element(off[k].begin(), off[k].end());
    result.note = fmt::format("said over is: {:.2f} to {:.2f}", *least, *most);
    std::nth_element(off[k].begin(), off[k].begin() + static_cast<ptrdiff_t>(off[k].size() / 2), off[k].end());
    result.median = off[k][off[k].size() / 2];
    report.add(result);
  }
  benchPieceCosts(report, options, machine);
}

}  // namespace argil::bench
