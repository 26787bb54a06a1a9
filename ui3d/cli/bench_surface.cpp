// argil bench surface: the whole model, beside OpenVDB's volumeToMesh of the same field.

#include <openvdb/openvdb.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include <fmt/format.h>

#include "clay/surface.h"
#include "clay/vdb_bridge.h"
#include "ui3d/cli/bench.h"
#include "ui3d/cli/bench_models.h"

namespace argil::cli {

void benchSurface(BenchReport& report, const BenchOptions& options) {
  report.heading("surface: the whole sphere from its field; positions and quads on both sides, then with normals");
  for (const double size : benchSizes(options.largest)) {
    const BenchModel model = benchSphere(size);
    const auto grid = std::static_pointer_cast<openvdb::FloatGrid>(clay::toVdb(model.version).grid);
    const int runs = size < 5 ? 15 : size < 20 ? 7 : 5;
    for (const int threads : {1, 2}) {
      Samples bare, normals, peer;
      uint64_t triangles = 0, hash = 0;
      for (int run = 0; run < runs; ++run) {
        if (options.job) options.job->step(0);
        for (const bool withNormals : {false, true}) {
          clay::Surface surface(withNormals);
          Stopwatch watch;
          surface.update(model.version, threads);
          (withNormals ? normals : bare).add(watch.us());
          triangles = 2 * surface.quadCount();
          if (withNormals && run == 0) hash = surface.hash();
        }
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<size_t>(threads));
        std::vector<openvdb::Vec3s> points;
        std::vector<openvdb::Vec3I> peerTriangles;
        std::vector<openvdb::Vec4I> quads;
        Stopwatch watch;
        openvdb::tools::volumeToMesh(*grid, points, peerTriangles, quads, 0, 0);
        peer.add(watch.us());
      }
      BenchResult r = bare.result(fmt::format("surface/full/{}", model.name));
      r.threads = threads;
      r.peer = peer.median();
      r.peerName = "volumeToMesh";
      r.triangles = triangles;
      r.note = fmt::format("{:.1f} M triangles/s", static_cast<double>(triangles) / r.median);
      report.add(r);
      r = normals.result(fmt::format("surface/full-normals/{}", model.name));
      r.threads = threads;
      r.peer = peer.median();
      r.peerName = "volumeToMesh";
      r.triangles = triangles;
      r.hash = hash;
      report.add(r);
    }
  }
}

}  // namespace argil::cli
