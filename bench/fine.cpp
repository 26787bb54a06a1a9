// argil bench fine: the crisp and the fine surface beside the draft of the same clay: where creases are, and where
// there are none.

#include <fmt/format.h>

#include <array>
#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <random>
#include <string_view>
#include <vector>

#include "bench/bench.h"
#include "bench/models.h"
#include "clay/brush/brush.h"
#include "clay/import/mesh_to_clay.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "io/models/model_file.h"

namespace argil::bench {

namespace {

constexpr double kTip = 12, kLength = 60;  // voxels, of a groove
constexpr int kGrooves = 40;
constexpr double kLargestBust = 12;  // million voxels: importing takes its time

/// Grooves from places of its surface on, anywhere: of so many voxels whatever its size. The larger the model, the
/// smaller the part of its surface that is at a rim.
void cutGrooves(clay::Version& version) {
  clay::Surface surface(false);
  surface.update(version);
  std::vector<Vec3d> places;
  surface.forEach([&](const clay::BrickMesh& mesh) {
    for (const Vec3f& p : mesh.positions)
      places.push_back((mesh.brick * clay::kBrickEdge).toVec3d() + p.cast<double>());
  });
  std::mt19937_64 random(3);
  std::normal_distribution<double> normal;
  for (int i = 0; i < kGrooves; ++i) {
    const Vec3d from = places[random() % places.size()],
                way = Vec3d(normal(random), normal(random), normal(random)).normalized();
    clay::BrushStroke stroke(version, clay::Brush::of(clay::Method::carve));
    for (int k = 0; k < kLength; ++k) stroke.apply(clay::Stamp{from + k * way, from + (k + 1) * way, kTip});
    version = stroke.finish();
  }
}

/// The test data's koala with about so many million active voxels.
BenchModel bust(double millions, const char* data) {
  clay::TriangleMesh mesh = io::merged(io::readModel(std::filesystem::path(data) / "mesh/koala_100k.obj").objects).mesh;
  clay::ImportOptions how;
  // 1.2 million where it is 400 voxels long.
  how.grid.voxelMm = clay::suggestVoxelMm(mesh, static_cast<int>(400 * std::sqrt(millions / 1.2)));
  return {fmt::format("{:.1f}M", millions), 0, clay::meshToClay(clay::Store::make(), mesh, how).version};
}

}  // namespace

void benchFine(BenchReport& report, const BenchOptions& options) {
  report.heading("fine: the whole surface with normals, on one thread; the peer is the draft of the same clay");
  constexpr std::array kGrades{clay::Grade::draft, clay::Grade::crisp, clay::Grade::fine};
  const char* data = std::getenv("ARGIL_DATA");
  if (!data) report.heading("fine: set ARGIL_DATA to the folder of test data for the bust");
  for (const double size : benchSizes(options.largest))
    for (const std::string_view shape : {"sphere", "carved", "cube", "bust", "carved bust"}) {
      const bool real = shape.ends_with("bust"), grooves = shape.starts_with("carved");
      if (real && (!data || size > kLargestBust)) continue;
      BenchModel model = real ? bust(size, data) : shape == "cube" ? benchCube(size) : benchSphere(size);
      if (grooves) cutGrooves(model.version);
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
