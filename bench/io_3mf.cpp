#include "bench/io_3mf.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <string>

#include "clay/base/error.h"

namespace argil::bench {

namespace {

namespace fs = std::filesystem;

/// kB; 0 where the system does not say. `which`: VmHWM (peak), VmRSS.
uint64_t memory(const char* which) {
  std::ifstream status("/proc/self/status");
  for (std::string line; std::getline(status, line);) {
    if (line.starts_with(which)) return std::stoull(line.substr(line.find(':') + 1));
  }
  return 0;
}

/// From here on VmHWM is the peak.
void forgetPeak() {
  std::ofstream("/proc/self/clear_refs") << "5";
}

void writeRaw(const fs::path& path, const clay::TriangleMesh& mesh) {
  std::ofstream raw(path, std::ios::binary);
  const auto put = [&](const auto& value) { raw.write(reinterpret_cast<const char*>(&value), sizeof value); };
  put(static_cast<uint32_t>(mesh.positions.size()));
  put(static_cast<uint32_t>(mesh.triangles.size()));
  for (const Vec3d& p : mesh.positions) {
    for (const double x : {p.x(), p.y(), p.z()}) put(static_cast<float>(x));
  }
  raw.write(reinterpret_cast<const char*>(mesh.triangles.data()),
            static_cast<std::streamsize>(mesh.triangles.size() * sizeof mesh.triangles[0]));
  if (!raw.flush()) throw Error("the folder of the benchmark is full", Error::Kind::work);
}

struct PeerRun {
  double seconds = 0;
  uint64_t peakKb = 0;
};

PeerRun runPeer(const fs::path& program, const fs::path& raw, const fs::path& out) {
  PeerRun result;
  const std::string command = fmt::format("'{}' '{}' '{}'", program.string(), raw.string(), out.string());
  FILE* pipe = ::popen(command.c_str(), "r");
  if (pipe == nullptr) throw Error("bench-lib3mf cannot be started", Error::Kind::work);
  unsigned long peak = 0;
  const bool told = std::fscanf(pipe, "%lf %lu", &result.seconds, &peak) == 2;
  if (::pclose(pipe) != 0 || !told) throw Error("bench-lib3mf failed", Error::Kind::work);
  result.peakKb = peak;
  return result;
}

}  // namespace

void benchThreeMf(BenchReport& report, const io::ModelView& model, const fs::path& folder, int runs, Job* job) {
  const clay::TriangleMesh& mesh = model.objects[0].mesh;
  const fs::path ours = folder / "bench-ours.3mf", theirs = folder / "bench-lib3mf.3mf",
                 raw = folder / "bench-mesh.raw";
  const fs::path program = fs::read_symlink("/proc/self/exe").parent_path() / "bench-lib3mf";
  const bool peerThere = fs::exists(program);
  if (peerThere) writeRaw(raw, mesh);
  Samples write, read, peer;
  uint64_t bytes = 0, peerBytes = 0, peakKb = 0, peerPeakKb = 0;
  for (int run = 0; run < runs; ++run) {
    if (job) job->step(0);
    forgetPeak();
    const uint64_t before = memory("VmRSS");
    Stopwatch watch;
    bytes = io::writeModel(ours, model).bytes;
    write.add(watch.us());
    peakKb = std::max(peakKb, memory("VmHWM") - std::min(before, memory("VmHWM")));
    if (peerThere) {
      const PeerRun of = runPeer(program, raw, theirs);
      peer.add(of.seconds * 1e6);
      peerPeakKb = of.peakKb;
      peerBytes = fs::file_size(theirs);
    }
    Stopwatch reading;
    const io::ModelFile back = io::readModel(ours);
    read.add(reading.us());
    if (back.objects.at(0).mesh.triangles != mesh.triangles)
      throw Error("a 3MF file was read back as something else", Error::Kind::work);
  }
  const auto inMs = [](BenchResult result) {
    result.unit = "ms";
    result.median /= 1000;
    return result;
  };
  BenchResult row = inMs(write.result("io/3mf/write"));
  row.triangles = mesh.triangles.size();
  row.bytes = bytes;
  row.note = fmt::format("{:.0f} MB beside the mesh, flushed to the disk", static_cast<double>(peakKb) / 1000);
  if (peerThere) {
    row.peer = peer.median() / 1000;
    row.peerName = "lib3mf";
    row.note += fmt::format("; size {:.3f} of lib3mf's {} bytes (not flushed; {:.0f} MB in all)",
                            static_cast<double>(bytes) / static_cast<double>(peerBytes), peerBytes,
                            static_cast<double>(peerPeakKb) / 1000);
  }
  report.add(row);
  row = inMs(read.result("io/3mf/read"));
  row.triangles = mesh.triangles.size();
  row.bytes = bytes;
  report.add(row);
  for (const fs::path& file : {ours, theirs, raw}) fs::remove(file);
}

}  // namespace argil::bench
