// argil bench render: what a picture costs, pass by pass, from 0.2 M triangles to as many as the device holds, and what
// a dab uploads.

#include <openvdb/openvdb.h>
#include <openvdb/tools/VolumeToMesh.h>
#include <tbb/global_control.h>

#include <cmath>
#include <map>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/models.h"
#include "clay/brush/brush.h"
#include "clay/store/store.h"
#include "clay/store/vdb_bridge.h"
#include "clay/surface/surface.h"
#include "render/renderer/renderer.h"

namespace argil::bench {

namespace {

using namespace clay;
using render::Quality;
using render::Renderer;

constexpr int kWidth = 1280, kHeight = 720;
constexpr double kDabVoxels = 20;
/// The closed surface of a sphere has half as many triangles as a band of 3 has active voxels.
constexpr double kTrianglesPerVoxel = 0.5;
constexpr int kMostSettling = 400;
constexpr uint64_t kLeastPictures = 7, kMostPictures = 60;
constexpr double kSecondsAKind = 3;

struct Scene {
  BenchModel sphere;
  Surface surface;
  std::string name;
  double millions = 0;  ///< Of triangles.
};

render::Shot shotOf(const Renderer& renderer, render::StereoMode mode) {
  render::Shot shot;
  shot.view = render::View::named("iso", renderer.bounds(), double(kWidth) / kHeight);
  shot.stereo.mode = mode;
  return shot;
}

struct Settling {
  int pictures = 0;
  double slowestMs = 0, allMs = 0;  ///< But for a first that makes shaders.
};

/// Levels of detail are made over several pictures, shaders with the first.
Settling settle(Renderer& renderer, const render::Shot& shot, bool shadersThere = false) {
  Settling settling;
  uint64_t before = 0;
  while (settling.pictures < kMostSettling) {
    Stopwatch watch;
    static_cast<void>(renderer.render(shot, kWidth, kHeight));
    const double ms = watch.us() / 1000;
    if (settling.pictures++ > 0 || shadersThere) {
      settling.slowestMs = std::max(settling.slowestMs, ms);
      settling.allMs += ms;
    }
    const Renderer::DrawStats stats = renderer.drawStats();
    if (stats.levelBytes == 0 && stats.trianglesDrawn == before) break;
    before = stats.trianglesDrawn;
  }
  return settling;
}

std::string passes(const std::map<std::string, Samples>& times, const std::vector<std::string>& order) {
  std::string line;
  for (const std::string& pass : order) line += fmt::format(" {} {:.2f}", pass, times.at(pass).median() / 1000);
  return line;
}

void pictures(BenchReport& report, const BenchOptions& options, Renderer& renderer, const Scene& scene) {
  using render::StereoMode;
  const struct {
    const char* name;
    Quality quality;
    StereoMode stereo;
  } kinds[] = {{"moving", Quality{}.moving(), StereoMode::mono},
               {"moving-side-by-side", Quality{}.moving(), StereoMode::sideBySide},
               {"still", Quality{}, StereoMode::mono},
               {"still-side-by-side", Quality{}, StereoMode::sideBySide},
               {"moving-all-triangles",
                [] {
                  Quality q = Quality{}.moving();
                  q.detailPixels = 0;
                  return q;
                }(),
                StereoMode::mono}};
  for (const auto& kind : kinds) {
    renderer.setQuality(kind.quality);
    const render::Shot shot = shotOf(renderer, kind.stereo);
    const Settling settled = settle(renderer, shot);
    Samples whole;
    std::map<std::string, Samples> times;
    std::vector<std::string> order;
    Stopwatch all;
    while (whole.count() < kMostPictures && (whole.count() < kLeastPictures || all.us() < kSecondsAKind * 1e6)) {
      if (options.job) options.job->step(0);
      Stopwatch watch;
      static_cast<void>(renderer.render(shot, kWidth, kHeight));
      whole.add(watch.us());
      for (const render::PassTime& pass : renderer.passTimes()) {
        if (times.find(pass.name) == times.end()) order.emplace_back(pass.name);
        times[pass.name].add(pass.us);
      }
    }
    const Renderer::DrawStats stats = renderer.drawStats();
    const std::string path = fmt::format("render/{}/{}", kind.name, scene.name);
    BenchResult r = whole.result(path);
    r.p99 = whole.quantile(0.99);
    r.chunks = stats.chunksDrawn;
    r.triangles = stats.trianglesDrawn;
    r.note = fmt::format(
        "{:.1f} frames/s, {:.1f} M triangles/s, {} draw calls, settled after {} pictures, "
        "the slowest {:.1f} ms; ms:{}",
        1e6 / whole.median(), double(stats.trianglesDrawn) / whole.median(), stats.drawCalls, settled.pictures,
        settled.slowestMs, passes(times, order));
    report.add(r);
    for (const std::string& pass : order) {
      BenchResult part = times.at(pass).result(path + "/" + pass);
      part.p99 = times.at(pass).quantile(0.99);
      report.keep(part);
    }
  }
}

/// What a model costs until each chunk is drawn at its level: levels made by the device beside levels made by the CPU.
void levels(BenchReport& report, const Scene& scene, const SurfaceDelta& whole) {
  using Levels = render::RendererOptions::Levels;
  std::map<Levels, Settling> settled;
  for (const Levels by : {Levels::device, Levels::cpu}) {
    render::RendererOptions options;
    options.levels = by;
    options.quality = Quality{}.moving();
    options.quality.detailPixels = 0;
    Renderer renderer(options);
    renderer.update(whole);
    const render::Shot shot = shotOf(renderer, render::StereoMode::mono);
    settle(renderer, shot);  // all shaders are there
    renderer.setQuality(Quality{}.moving());
    settled[by] = settle(renderer, shot, true);
  }
  const auto &device = settled.at(Levels::device), &cpu = settled.at(Levels::cpu);
  Samples all;
  all.add(device.allMs * 1000);
  BenchResult r = all.result("render/levels/" + scene.name);
  r.peer = cpu.allMs * 1000;
  r.peerName = "by the CPU";
  r.note =
      fmt::format("until all are made, pictures included: {} pictures, the slowest {:.1f} ms; by the CPU {}, {:.1f}",
                  device.pictures, device.slowestMs, cpu.pictures, cpu.slowestMs);
  report.add(r);
}

/// A dab's surface onto the device; beside it what a renderer does that knows nothing of bricks: mesh the whole field,
/// send the whole.
void dabs(BenchReport& report, const BenchOptions& options, Renderer& renderer, Scene& scene) {
  renderer.setQuality(Quality{}.moving());
  const render::Shot shot = shotOf(renderer, render::StereoMode::mono);
  settle(renderer, shot);
  const Version base = scene.sphere.version;
  const Vec3d centre = base.grid().toVoxel(Vec3d(3, 5, 7));
  Samples upload, bytes, frame;
  uint64_t after = 0;
  Version last;
  constexpr int kDabs = 24;
  for (int i = 0; i < kDabs; ++i) {
    if (options.job) options.job->step(0);
    const double angle = 0.4 + 0.9 * kDabVoxels / scene.sphere.radiusVoxels * i;
    const Vec3d at = centre + scene.sphere.radiusVoxels * Vec3d(std::sin(angle), -std::cos(angle), 0.3).normalized();
    BrushStroke stroke(i == 0 ? base : last, Brush::of(Method::carve));
    stroke.apply({at, at, kDabVoxels});
    last = stroke.publish();
    const SurfaceDelta delta = scene.surface.update(last);
    Stopwatch watch;
    const render::UploadStats stats = renderer.update(delta);
    upload.add(watch.us());
    bytes.add(double(stats.bytes));
    Stopwatch picture;
    static_cast<void>(renderer.render(shot, kWidth, kHeight));
    frame.add(picture.us());
    after += renderer.drawStats().levelBytes;
  }
  // What the stroke left to be done once the hand rests.
  for (int i = 0; i < 24; ++i) {
    static_cast<void>(renderer.render(shot, kWidth, kHeight));
    after += renderer.drawStats().levelBytes;
  }

  const auto grid = std::static_pointer_cast<openvdb::FloatGrid>(toVdb(last).grid);
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, 1);
  Samples peer;
  uint64_t peerBytes = 0;
  for (int run = 0; run < (scene.millions > 5 ? 1 : 3); ++run) {
    std::vector<openvdb::Vec3s> points;
    std::vector<openvdb::Vec3I> triangles;
    std::vector<openvdb::Vec4I> quads;
    Stopwatch watch;
    openvdb::tools::volumeToMesh(*grid, points, triangles, quads, 0, 0);
    TriangleMesh mesh;
    mesh.positions.reserve(points.size());
    for (const openvdb::Vec3s& p : points) mesh.positions.emplace_back(p.x(), p.y(), p.z());
    for (const openvdb::Vec4I& q : quads) {
      mesh.triangles.push_back({q[0], q[1], q[2]});
      mesh.triangles.push_back({q[0], q[2], q[3]});
    }
    peerBytes = mesh.positions.size() * 24 + mesh.triangles.size() * 12;
    peer.add(watch.us());
  }
  BenchResult r = upload.result("render/dab-upload/" + scene.name);
  r.p99 = upload.quantile(0.99);
  r.bytes = uint64_t(bytes.median());
  r.peer = peer.median();
  r.peerName = "volumeToMesh of the whole (its copy to the device not counted)";
  r.note = fmt::format(
      "{:.2f} MB with 24 bytes a vertex and 12 a triangle there; levels of all {} dabs, once at rest: {:.2f} MB",
      double(peerBytes) / 1e6, kDabs, double(after) / 1e6);
  report.add(r);
  r = frame.result("render/dab-picture/" + scene.name);
  r.p99 = frame.quantile(0.99);
  report.add(r);
  scene.surface.update(base);
}

}  // namespace

void benchRender(BenchReport& report, const BenchOptions& options) {
  if (render::devices().empty())
    throw Error(
        "bench render: no Vulkan driver; install mesa-vulkan-drivers (it draws in software where there is no GPU)",
        Error::Kind::work);
  report.heading(
      "render: a sphere that fills 1280×720; a picture from the call to its bytes, passes by the device's clock");
  for (const double millions : {0.2, 1.0, 10.0, 40.0}) {
    if (millions / kTrianglesPerVoxel > options.largest * 1.05) break;
    Scene scene{benchSphere(millions / kTrianglesPerVoxel), Surface(), fmt::format("{:g}M-tri", millions), millions};
    Renderer renderer;
    Stopwatch extraction;
    const SurfaceDelta delta = scene.surface.update(scene.sphere.version, 2);
    const double extracted = extraction.us();
    Stopwatch watch;
    const render::UploadStats stats = renderer.update(delta);
    Samples load;
    load.add(watch.us());
    BenchResult r = load.result("render/load/" + scene.name);
    r.triangles = renderer.triangleCount();
    r.bytes = stats.bytes;
    r.note = fmt::format("on {}; its surface was made in {:.0f} ms", renderer.deviceName(), extracted / 1000);
    report.add(r);
    levels(report, scene, delta);
    pictures(report, options, renderer, scene);
    dabs(report, options, renderer, scene);
  }
}

}  // namespace argil::bench
