// argil bench fine: the crisp and the fine surface beside the draft of the same clay: where creases are, and where
// there are none.

#include <fmt/format.h>

#include <array>
#include <random>
#include <string_view>

#include "bench/bench.h"
#include "bench/models.h"
#include "clay/brush/brush.h"
#include "clay/surface/surface.h"

namespace argil::bench {

namespace {

/// The sphere with grooves of 12 voxels' radius cut into it here and there. The larger the sphere, the smaller the part
/// of its surface that is at a rim.
BenchModel carved(double size) {
  constexpr double kTip = 12, kLength = 60;
  constexpr int kGrooves = 40;
  BenchModel model = benchSphere(size);
  const clay::Grid grid = model.version.grid();
  const Vec3d centre = (Vec3d(3, 5, 7) - grid.originMm) / grid.voxelMm;
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  const auto direction = [&] { return Vec3d(normal(random), normal(random), normal(random)).normalized(); };
  for (int i = 0; i < kGrooves; ++i) {
    const Vec3d from = model.radiusVoxels * direction(),
                to = model.radiusVoxels * (from + kLength * direction()).normalized();
    clay::BrushStroke stroke(model.version, clay::Brush::of(clay::Method::carve));
    for (int k = 0; k < kLength; ++k)
      stroke.apply(clay::Stamp{centre + from + (to - from) * (k / kLength),
                               centre + from + (to - from) * ((k + 1) / kLength), kTip});
    model.version = stroke.finish();
  }
  return model;
}

}  // namespace

void benchFine(BenchReport& report, const BenchOptions& options) {
  report.heading("fine: the whole surface with normals, on one thread; the peer is the draft of the same clay");
  constexpr std::array kGrades{clay::Grade::draft, clay::Grade::crisp, clay::Grade::fine};
  for (const double size : benchSizes(options.largest))
    for (const std::string_view shape : {"sphere", "carved", "cube"}) {
      const BenchModel model = shape == "cube" ? benchCube(size) : shape == "carved" ? carved(size) : benchSphere(size);
      const int runs = size < 5 ? 15 : 5;
      std::array<Samples, kGrades.size()> times;
      std::array<uint64_t, kGrades.size()> hashes{};
      uint64_t triangles = 0;
      for (int run = 0; run < runs; ++run)
        for (size_t k = 0; k < kGrades.size(); ++k) {
          if (options.job) options.job->step(0);
          clay::Surface surface(true, kGrades[k]);
          const Stopwatch watch;
          surface.update(model.version);
          times[k].add(watch.us());
          triangles = 2 * surface.quadCount();
          if (run == 0) hashes[k] = surface.hash();
        }
      for (const size_t k : {1, 2}) {
        BenchResult r = times[k].result(fmt::format("{}/{}/{}", k == 1 ? "crisp" : "fine", shape, model.name));
        r.peer = times[0].median();
        r.peerName = "draft";
        r.triangles = triangles;
        r.hash = hashes[k];
        report.add(r);
      }
    }
  benchFineError(report, options);
}

}  // namespace argil::bench
