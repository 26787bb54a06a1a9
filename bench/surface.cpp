// argil bench surface: the whole model, beside OpenVDB's volumeToMesh of the same field.

#include <openvdb/openvdb.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstring>
#include <vector>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/models.h"
#include "clay/store/vdb_bridge.h"
#include "clay/surface/surface.h"

namespace argil::bench {

namespace {

// Gigabytes a second that memcpy moves from one large buffer to another, each byte counted once; the best of some.
double copyBandwidth() {
  constexpr size_t kBytes = size_t{256} << 20;
  const std::vector<char> from(kBytes, 1);
  std::vector<char> to(kBytes, 2);
  double best = 0;
  for (int run = 0; run < 7; ++run) {
    Stopwatch watch;
    std::memcpy(to.data(), from.data(), kBytes);
    best = std::max(best, static_cast<double>(kBytes) / watch.us() * 1e-3);
  }
  return best;
}

}  // namespace

void benchSurface(BenchReport& report, const BenchOptions& options) {
  const double copy = copyBandwidth();
  report.heading(
      fmt::format("surface: the whole sphere from its field; positions and quads on both sides, then with normals; "
                  "memcpy copies {:.1f} GB/s",
                  copy));
  for (const double size : benchSizes(options.largest)) {
    const BenchModel model = benchSphere(size);
    const auto grid = std::static_pointer_cast<openvdb::FloatGrid>(clay::toVdb(model.version).grid);
    const int runs = size < 5 ? 15 : size < 20 ? 7 : 5;
    for (const int threads : {1, 2}) {
      Samples bare, normals, peer;
      uint64_t triangles = 0, hash = 0, vertices = 0;
      for (int run = 0; run < runs; ++run) {
        if (options.job) options.job->step(0);
        for (const bool withNormals : {false, true}) {
          clay::Surface surface(withNormals);
          Stopwatch watch;
          surface.update(model.version, threads);
          (withNormals ? normals : bare).add(watch.us());
          triangles = 2 * surface.quadCount();
          vertices = surface.vertexCount();
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
      const auto add = [&](const Samples& samples, const char* what, size_t vertexBytes) {
        BenchResult r = samples.result(fmt::format("surface/{}/{}", what, model.name));
        r.threads = threads;
        r.peer = peer.median();
        r.peerName = "volumeToMesh";
        r.triangles = triangles;
        r.bytes = vertices * vertexBytes + triangles / 2 * sizeof(std::array<clay::VertexRef, 4>);
        const double speed = static_cast<double>(*r.bytes) / r.median * 1e-3;
        r.note = fmt::format("{:.1f} M triangles/s, {:.2f} GB/s of surface: {:.0f} % of the copy",
                             static_cast<double>(triangles) / r.median, speed, 100 * speed / copy);
        if (vertexBytes > sizeof(Vec3f)) r.hash = hash;
        report.add(r);
      };
      add(bare, "full", sizeof(Vec3f));
      add(normals, "full-normals", sizeof(Vec3f) + sizeof(clay::PackedNormal));
    }
  }
}

}  // namespace argil::bench
