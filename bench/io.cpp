// argil bench io: writing and reading every format, beside the same bytes written from memory; reducing.

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <functional>
#include <vector>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/io_3mf.h"
#include "bench/models.h"
#include "bench/peak_memory.h"
#include "clay/base/error.h"
#include "clay/mesh/reduce.h"
#include "clay/surface/surface.h"
#include "io/models/model_file.h"
#include "io/models/model_writer.h"

namespace argil::bench {

namespace {

namespace fs = std::filesystem;

constexpr double kMostTriangles = 10;  ///< Millions.
constexpr int kRuns = 3;
constexpr size_t kRawPiece = size_t{4} << 20;  ///< Bytes that the raw write hands over at a time.

/// A torus as a net, closed.
clay::TriangleMesh torus(double millions) {
  const auto across = static_cast<uint32_t>(std::lround(std::sqrt(millions * 1e6 / 4))), around = 2 * across;
  clay::TriangleMesh mesh;
  mesh.positions.reserve(size_t{across} * around);
  mesh.triangles.reserve(2 * size_t{across} * around);
  for (uint32_t i = 0; i < around; ++i)
    for (uint32_t j = 0; j < across; ++j) {
      const double a = 2 * M_PI * i / around, b = 2 * M_PI * j / across, r = 30 + 10 * std::cos(b);
      mesh.positions.emplace_back(r * std::cos(a), r * std::sin(a), 10 * std::sin(b));
      const uint32_t i1 = (i + 1) % around, j1 = (j + 1) % across;
      mesh.triangles.push_back({i * across + j, i1 * across + j, i1 * across + j1});
      mesh.triangles.push_back({i * across + j, i1 * across + j1, i * across + j1});
    }
  return mesh;
}

struct RawTimes {
  double us = 0, beforeFlushUs = 0;
};

RawTimes writeRaw(const fs::path& path, const std::vector<char>& bytes) {
  const Stopwatch watch;
  const int file = ::open(path.c_str(), O_WRONLY | O_CREAT | O_TRUNC | O_CLOEXEC, 0666);
  for (size_t at = 0; file >= 0 && at < bytes.size();) {
    const ssize_t done = ::write(file, bytes.data() + at, std::min(kRawPiece, bytes.size() - at));
    if (done < 0) break;
    at += static_cast<size_t>(done);
  }
  RawTimes times;
  times.beforeFlushUs = watch.us();
  const bool written = file >= 0 && ::fsync(file) == 0;
  if (file >= 0) ::close(file);
  times.us = watch.us();
  if (!written || fs::file_size(path) != bytes.size())
    throw Error(
        fmt::format("bench --folder {}: cannot be written ({})", path.parent_path().string(), std::strerror(errno)),
        Error::Kind::work);
  return times;
}

BenchResult inMs(BenchResult result) {
  result.unit = "ms";
  result.median /= 1000;
  return result;
}

/// Writes a file several times, flushed to the disk each time, beside the same bytes from memory; then reads it.
class Rows {
 public:
  Rows(BenchReport& report, const fs::path& folder, uint64_t triangles, Job* job)
      : report_(report), folder_(folder), triangles_(triangles), job_(job) {}

  /// `file`: its ending says what reads it. `write` returns the bytes of the file.
  void add(const std::string& name, const std::string& file, const std::function<uint64_t(const fs::path&)>& write,
           bool readBack = true) {
    const fs::path path = folder_ / file, rawPath = folder_ / "bench-raw.bin";
    Samples writing, raw, rawBeforeFlush, reading;
    uint64_t size = 0, writeMemory = 0, readMemory = 0;
    for (int run = 0; run < kRuns; ++run) {
      if (job_) job_->step(0);
      {
        const PeakMemory peak;
        const Stopwatch watch;
        size = write(path);
        writing.add(watch.us());
        writeMemory = std::max(writeMemory, peak.bytes());
      }
      if (readBack) {
        const PeakMemory peak;
        const Stopwatch watch;
        const io::ModelFile back = io::readModel(path, job_);
        reading.add(watch.us());
        readMemory = std::max(readMemory, peak.bytes());
        uint64_t triangles = 0;
        for (const io::ModelObject& object : back.objects) triangles += object.mesh.triangles.size();
        if (triangles != triangles_)
          throw Error(fmt::format("{} was read back with {} triangles of {}", file, triangles, triangles_),
                      Error::Kind::work);
      }
      std::vector<char> bytes(size);
      std::ifstream(path, std::ios::binary).read(bytes.data(), static_cast<std::streamsize>(size));
      fs::remove(path);
      const RawTimes times = writeRaw(rawPath, bytes);
      fs::remove(rawPath);
      raw.add(times.us);
      rawBeforeFlush.add(times.beforeFlushUs);
    }
    BenchResult row = inMs(writing.result("io/" + name + "/write"));
    row.peer = raw.median() / 1000;
    row.peerName = "its bytes from memory";
    row.triangles = triangles_;
    row.bytes = size;
    row.memory = writeMemory;
    row.note = fmt::format("{:.0f} MB/s; from memory without flushing {:.0f} ms",
                           static_cast<double>(size) / writing.median(), rawBeforeFlush.median() / 1000);
    report_.add(row);
    if (!readBack) return;
    row = inMs(reading.result("io/" + name + "/read"));
    row.triangles = triangles_;
    row.bytes = size;
    row.memory = readMemory;
    report_.add(row);
  }

 private:
  BenchReport& report_;
  fs::path folder_;
  uint64_t triangles_;
  Job* job_;
};

void benchReduction(BenchReport& report, double millions, Job* job) {
  // Two triangles for every four active voxels of a band of three on each side.
  const BenchModel model = benchSphere(2 * millions);
  clay::Surface surface(false);
  surface.update(model.version, 2);
  const clay::TriangleMesh mesh = surface.toMesh();
  surface = clay::Surface(false);
  const double voxel = model.version.grid().voxelMm;
  const auto row = [&](const std::string& name, const clay::ReduceOptions& options) {
    Samples samples;
    const PeakMemory peak;
    const Stopwatch watch;
    const clay::Reduced reduced = clay::reduce(mesh, options, job);
    samples.add(watch.us());
    BenchResult result = inMs(samples.result("io/reduce/" + name));
    result.triangles = reduced.mesh.triangles.size();
    result.memory = peak.bytes();
    result.note = fmt::format("of {}; measured {:.5f} mm at most ({:.3f} voxel), RMS {:.5f}, at {} points",
                              mesh.triangles.size(), reduced.deviation.most(), reduced.deviation.most() / voxel,
                              reduced.deviation.rmsMm, reduced.deviation.points);
    report.add(result);
  };
  row("tenth", {mesh.triangles.size() / 10, {}});
  row("hundredth", {mesh.triangles.size() / 100, {}});
  row("within-half-voxel", {{}, voxel / 2});
}

}  // namespace

void benchIo(BenchReport& report, const BenchOptions& options) {
  const fs::path folder = options.folder.empty() ? fs::temp_directory_path() : options.folder;
  if (!fs::is_directory(folder))
    throw Error(fmt::format("bench --folder {}: there is no such folder; make it first", folder.string()));
  const double millions = std::min(kMostTriangles, options.largest / 2);
  io::ModelObject object;
  object.mesh = torus(millions);
  const io::ModelView model{{&object, 1}, {}};
  report.heading(fmt::format(
      "io: a closed mesh of {} triangles, files in {}, flushed to the disk; then the surface of clay reduced",
      object.mesh.triangles.size(), folder.string()));
  const uint64_t triangles = object.mesh.triangles.size();
  Rows rows(report, folder, triangles, options.job);
  const auto writer = [&](const io::WriteOptions& how) {
    return
        [&model, how, job = options.job](const fs::path& path) { return io::writeModel(path, model, how, job).bytes; };
  };
  rows.add("stl", "bench.stl", writer({}));
  rows.add("stl-distinct", "bench.stl", writer({.distinct = true}), false);
  rows.add("ply", "bench.ply", writer({}));
  rows.add("obj", "bench.obj", writer({}));
  rows.add("drc", "bench.drc", writer({}));
  rows.add("glb", "bench.glb", writer({}));
  benchThreeMf(report, model, folder, kRuns, options.job);
  object = {};
  benchReduction(report, millions, options.job);
}

}  // namespace argil::bench
