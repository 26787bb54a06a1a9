// argil bench day, part (d): a scan of many triangles becomes clay.

#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include <fmt/format.h>

#include "bench/day.h"
#include "bench/peak_memory.h"
#include "engine/models/model_files.h"
#include "io/models/mesh_writer.h"

namespace argil::bench {
namespace {

namespace fs = std::filesystem;

constexpr double kMillionTriangles = 30;  // of a full day, whose largest model has 48 M voxels
constexpr double kFullMillions = 48;

// A ball with bumps, closed; rings of `around` vertices between two poles.
clay::TriangleMesh scan(uint64_t triangles) {
  const auto around = static_cast<uint32_t>(std::max(8.0, std::sqrt(double(triangles))));
  const uint32_t rings = static_cast<uint32_t>(triangles / 2 / around);
  clay::TriangleMesh mesh;
  mesh.positions.reserve(uint64_t{rings} * around + 2);
  mesh.triangles.reserve(2 * uint64_t{rings} * around);
  const auto place = [](double lean, double turn) {
    const Vec3d direction(std::sin(lean) * std::cos(turn), std::sin(lean) * std::sin(turn), std::cos(lean));
    return Vec3d(direction * (50 + 2 * std::sin(9 * lean) * std::sin(lean) * std::cos(7 * turn) +
                              0.2 * std::sin(90 * lean) * std::sin(lean)));
  };
  for (uint32_t i = 0; i < rings; ++i)
    for (uint32_t j = 0; j < around; ++j)
      mesh.positions.push_back(place(M_PI * (i + 1) / (rings + 1), 2 * M_PI * j / around));
  const auto top = static_cast<uint32_t>(mesh.positions.size());
  mesh.positions.push_back(place(0, 0));
  mesh.positions.push_back(place(M_PI, 0));
  for (uint32_t j = 0; j < around; ++j) {
    const uint32_t k = (j + 1) % around;
    mesh.triangles.push_back({top, j, k});
    for (uint32_t i = 0; i + 1 < rings; ++i) {
      const uint32_t a = i * around + j, b = i * around + k, c = a + around, d = b + around;
      mesh.triangles.push_back({a, c, d});
      mesh.triangles.push_back({a, d, b});
    }
    mesh.triangles.push_back({(rings - 1) * around + j, top + 1, (rings - 1) * around + k});
  }
  return mesh;
}

}  // namespace

void benchDayImport(BenchReport& report, const BenchOptions& options) {
  const auto triangles =
      static_cast<uint64_t>(kMillionTriangles * 1e6 * std::min(1.0, options.largest / kFullMillions));
  report.heading(
      fmt::format("day, import: a binary STL of {:.1f} M triangles, read and made clay with 512 voxels along its side",
                  double(triangles) / 1e6));
  const fs::path folder = (options.folder.empty() ? fs::temp_directory_path() : options.folder) /
                          fmt::format("argil-bench-import-{}", getpid());
  fs::create_directories(folder);
  const fs::path file = folder / "scan.stl";
  uint64_t meshBytes = 0;
  {
    const clay::TriangleMesh mesh = scan(triangles);
    meshBytes = mesh.positions.size() * sizeof(mesh.positions[0]) + mesh.triangles.size() * sizeof(mesh.triangles[0]);
    io::writeMesh(file, mesh);
  }
  engine::ModelImport how;
  how.voxelMm = 104.0 / 512;
  Stopwatch watch;
  double readUs = 0;
  how.onRead = [&](const std::shared_ptr<const clay::TriangleMesh>&) { readUs = watch.us(); };
  const PeakMemory peak;
  const engine::ImportedModel model = engine::importModel(file, how, options.job);
  const double us = watch.us();
  BenchResult r;
  r.name = fmt::format("day/import/{:g}M-triangles", std::round(double(triangles) / 1e5) / 10);
  r.median = us;
  r.n = 1;
  r.threads = 0;
  r.triangles = triangles;
  r.bytes = meshBytes;
  r.memory = peak.bytes();
  r.bricks = model.pieces.empty() ? 0 : model.pieces.front().version.stats().bricks;
  r.note = fmt::format("read in {:.2f} s; memory at the peak {:.2f}× the mesh", readUs / 1e6,
                       double(peak.bytes()) / double(meshBytes));
  report.add(std::move(r));
  fs::remove_all(folder);
}

}  // namespace argil::bench
