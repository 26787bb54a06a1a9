// argil bench cad: quads, smooth faces and unwrapping of real models and of random sculpts, beside QuadriFlow and smart
// UV projection, where Blender is.

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <random>
#include <string>
#include <vector>

#include "bench/bench.h"
#include "bench/export/closed_model.h"
#include "clay/cage/fit_cage.h"
#include "clay/cage/flat_quads.h"
#include "clay/field/primitives.h"
#include "clay/field/region_work.h"
#include "clay/mesh/reduce.h"
#include "clay/store/store.h"
#include "clay/unwrap/charts.h"
#include "clay/unwrap/unwrap.h"
#include "clay/whole/boolean.h"
#include "io/bytes/child_process.h"
#include "io/models/mesh_writer.h"
#include "io/models/model_file.h"

namespace argil::bench {

namespace {

using namespace clay;
namespace fs = std::filesystem;

constexpr size_t kFewQuads = 500, kQuads = 2000, kManyQuads = 10000;
constexpr double kSculptVoxelMm = 0.5;
constexpr double kBadJacobian = 0.2, kEnough = 0.95;
constexpr const char* kBlender = "/usr/bin/blender";

// Remeshes the first file to so many quads, unwraps the result, writes it to the second, and tells of it.
constexpr const char* kPeer = R"(
import bpy, bmesh, json, math, sys, time
source, count, target, told = sys.argv[sys.argv.index('--') + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
bpy.ops.wm.obj_import(filepath=source, forward_axis='Y', up_axis='Z')
thing = bpy.context.selected_objects[0]
bpy.context.view_layer.objects.active = thing
before = len(thing.data.polygons)
start = time.time()
bpy.ops.object.quadriflow_remesh(target_faces=int(count))
said = {'seconds': time.time() - start, 'faces': len(thing.data.polygons), 'refused': len(thing.data.polygons) == before}
mesh = bmesh.new()
mesh.from_mesh(thing.data)
said['irregular'] = sum(1 for v in mesh.verts if len(v.link_edges) != 4)
mesh.free()
if not said['refused']:
    bpy.ops.object.mode_set(mode='EDIT')
    bpy.ops.mesh.select_all(action='SELECT')
    start = time.time()
    bpy.ops.uv.smart_project()
    said['unwrapping'] = time.time() - start
    bpy.ops.object.mode_set(mode='OBJECT')
    from bpy_extras import mesh_utils
    data = thing.data
    said['charts'] = len(mesh_utils.mesh_linked_uv_islands(data))
    uv = data.uv_layers.active.data
    data.calc_loop_triangles()
    covered = surface = stretch = 0.0
    flipped = 0
    for t in data.loop_triangles:
        a, b, c = (data.vertices[i].co for i in t.vertices)
        u, v, w = (uv[i].uv for i in t.loops)
        flat = 0.5 * ((v - u).x * (w - u).y - (v - u).y * (w - u).x)
        own = 0.5 * (b - a).cross(c - a).length
        if own <= 0:
            continue
        surface += own
        if flat <= 0:
            flipped += 1
            continue
        covered += flat
        x = ((b - a) * (w - u).y - (c - a) * (v - u).y) / (2 * flat)
        y = ((c - a) * (v - u).x - (b - a) * (w - u).x) / (2 * flat)
        stretch += own * (x.length_squared + y.length_squared) / 2
    said['covered'] = covered
    said['flipped'] = flipped
    said['stretch'] = math.sqrt(stretch / surface * covered / surface) if surface else 0
bpy.ops.wm.obj_export(filepath=target, forward_axis='Y', up_axis='Z', export_materials=False, export_uv=False)
json.dump(said, open(told, 'w'))
)";

struct Peer {
  bool refused = false, failed = false;
  size_t faces = 0, irregular = 0, charts = 0, flipped = 0;
  double seconds = 0, unwrapping = 0, covered = 0, stretch = 0;
  Deviation off;
};

// None without Blender.
std::optional<Peer> byPeer(const TriangleMesh& given, const TriangleMesh& surface, size_t quads,
                           const fs::path& folder) {
  if (!fs::exists(kBlender)) return std::nullopt;
  const fs::path script = folder / "peer.py", in = folder / "peer-in.obj", out = folder / "peer-out.obj",
                 told = folder / "peer.json";
  std::ofstream(script) << kPeer;
  io::writeMesh(in, given);
  fs::remove(out);
  fs::remove(told);
  Peer peer;
  io::ChildProcess process(kBlender,
                           {"-b", "--factory-startup", "-P", script.string(), "--", in.string(), std::to_string(quads),
                            out.string(), told.string()},
                           {});
  (void)process.wait();
  std::ifstream file(told);
  const nlohmann::json said = nlohmann::json::parse(file, nullptr, false);
  if (said.is_discarded() || !fs::exists(out)) {
    peer.failed = true;
    return peer;
  }
  peer.refused = said.value("refused", true);
  peer.faces = said.value("faces", size_t{0});
  peer.irregular = said.value("irregular", size_t{0});
  peer.seconds = said.value("seconds", 0.0);
  if (peer.refused) return peer;
  peer.charts = said.value("charts", size_t{0});
  peer.flipped = said.value("flipped", size_t{0});
  peer.unwrapping = said.value("unwrapping", 0.0);
  peer.covered = said.value("covered", 0.0);
  peer.stretch = said.value("stretch", 0.0);
  peer.off = deviation(surface, io::merged(io::readModel(out).objects).mesh);
  return peer;
}

struct Totals {
  size_t models = 0, refused = 0, peerRefused = 0, peers = 0;
  double worstShare = 0;                              // the largest deviation, of the model's size
  std::vector<double> irregular, rms, most, seconds;  // ours of the peer's
  std::vector<double> least;                          // scaled Jacobians
  size_t bad = 0, quads = 0, few = 0;                 // quads below kBadJacobian, all; models with fewer than asked for
  size_t charts = 0;
  double stretch = 0, covered = 1;
};

// Of edges that lie on creases, mm; each is a side of two quads.
double creasesIn(const QuadMesh& mesh) {
  double length = 0;
  for (size_t f = 0; f < mesh.creases.size(); ++f)
    for (size_t s = 0; s < 4; ++s)
      if ((mesh.creases[f] >> s & 1) != 0)
        length += 0.5 * (mesh.positions[mesh.quads[f][s]] - mesh.positions[mesh.quads[f][(s + 1) & 3]]).norm();
  return length;
}

void quadsOf(BenchReport& report, const BenchOptions& options, const std::string& name, const Version& version,
             size_t quads, const fs::path& folder, bool beside, Totals& totals) {
  const int threads = threadCount(options.threads);
  ++totals.models;
  const Stopwatch watch;
  FlatQuads made;
  try {
    made = flatQuads(version, quads, false, threads, WorkPart(options.job));
  } catch (const Cancelled&) {
    throw;
  } catch (const Error& e) {
    ++totals.refused;
    report.heading(fmt::format("{}: refused: {}", name, e.what()));
    return;
  }
  const double quadsUs = watch.us();
  const QuadMesh& mesh = made.mesh;
  const TriangleMesh& surface = made.maker->surface();
  const QuadShapes shapes = shapesOf(mesh);
  const Stopwatch flat;
  const UvMap map = unwrapped(mesh, {}, WorkPart(options.job));
  const double flatUs = flat.us();
  const auto bad = static_cast<size_t>(
      std::ranges::count_if(mesh.quads, [&](const auto& quad) { return scaledJacobian(mesh, quad) < kBadJacobian; }));
  totals.least.push_back(shapes.least);
  totals.bad += bad;
  totals.quads += mesh.quads.size();
  if (double(mesh.quads.size()) < kEnough * double(quads)) ++totals.few;
  const double creases = made.maker->creases().lengthMm();
  const size_t irregular = QuadTopology(mesh.positions.size(), mesh.quads).irregular();  // on creases as elsewhere
  const Deviation off = deviation(surface, trianglesOf(mesh));
  Vec3d low = surface.positions.front(), high = low;
  for (const Vec3d& p : surface.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double size = (high - low).maxCoeff();
  totals.worstShare = std::max(totals.worstShare, off.most() / size);
  totals.charts = std::max(totals.charts, map.charts);
  totals.stretch = std::max(totals.stretch, map.stretch);
  totals.covered = std::min(totals.covered, map.covered);
  Samples samples;
  samples.add(quadsUs);
  BenchResult result = samples.result(fmt::format("cad/quads/{}/{}", name, quads));
  result.threads = threads;
  result.note = fmt::format(
      "{} quads, halved {} times; {} irregular; scaled Jacobian {:.2f} in the mean, {:.2f} at least, {} below "
      "0.2; off {:.2g} RMS {:.2g} most mm; {} charts, {:.0f} % covered, stretch {:.4f}, {:.1f} s",
      mesh.quads.size(), made.halvings, irregular, shapes.mean, shapes.least, bad, off.rmsMm, off.most(), map.charts,
      100 * map.covered, map.stretch, flatUs * 1e-6);
  if (made.tooFarMm > 0)
    result.note += fmt::format("; more than asked for, which would lie up to {:.2g} mm off", made.tooFarMm);
  if (creases > 0) result.note += fmt::format("; {:.1f} % of creases are edges", 100 * creasesIn(mesh) / creases);
  // Of the fine surface QuadriFlow refuses edges without a length, which lie on creases.
  Surface draft(false);
  if (beside) draft.update(version, threads);
  if (const std::optional<Peer> peer = beside ? byPeer(draft.toMesh(), surface, quads, folder) : std::nullopt) {
    ++totals.peers;
    result.peerName = "QuadriFlow";
    result.peer = peer->seconds * 1e6;
    result.ratio = *result.peer / result.median;
    if (peer->failed || peer->refused) {
      ++totals.peerRefused;
      result.note += peer->failed ? " | QuadriFlow: failed" : " | QuadriFlow: refused";
    } else {
      result.note += fmt::format(
          " | QuadriFlow: {} quads; {} irregular; off {:.2g} RMS {:.2g} most; smart project: {} charts, {:.0f} % "
          "covered, stretch {:.4f}, {} flipped, {:.1f} s",
          peer->faces, peer->irregular, peer->off.rmsMm, peer->off.most(), peer->charts, 100 * peer->covered,
          peer->stretch, peer->flipped, peer->unwrapping);
      totals.irregular.push_back(double(irregular) / double(std::max<size_t>(1, peer->irregular)));
      totals.rms.push_back(off.rmsMm / peer->off.rmsMm);
      totals.most.push_back(off.most() / peer->off.most());
      totals.seconds.push_back(quadsUs * 1e-6 / peer->seconds);
    }
  }
  report.add(result);
}

void facesOf(BenchReport& report, const BenchOptions& options, const std::string& name, const Version& version,
             size_t faces) {
  const int threads = threadCount(options.threads);
  const Stopwatch watch;
  const FittedPatches fitted = fitPatches(version, faces, threads, WorkPart(options.job));
  Samples samples;
  samples.add(watch.us());
  BenchResult result = samples.result(fmt::format("cad/faces/{}/{}", name, faces));
  result.threads = threads;
  const OneWay &there = fitted.deviation.fromPatches, &back = fitted.deviation.fromClay;
  result.note = fmt::format(
      "{} faces, {} irregular; to the clay {:.2g} {:.2g} {:.2g} mm (RMS, p99, most; bound {:.2g}), from it {:.2g} "
      "{:.2g} {:.2g}; folds at {} places",
      fitted.surface.patches.size(), fitted.irregular, there.rms, there.p99, there.max, fitted.deviation.boundMm,
      back.rms, back.p99, back.max, fitted.deviation.foldsMm.size());
  report.add(result);
}

// Balls, rods and rings joined and cut as they come.
Version randomSculpt(unsigned seed) {
  std::mt19937 random(seed);
  const auto part = [&](double low, double high) {
    return low + (high - low) * std::uniform_real_distribution<double>()(random);
  };
  const auto place = [&](double reach) { return Vec3d(part(-reach, reach), part(-reach, reach), part(-reach, reach)); };
  Grid grid;
  grid.voxelMm = kSculptVoxelMm;
  Version version = makeSphere(Store::make(), grid, Vec3d::Zero(), part(10, 16));
  const int steps = 3 + int(random() % 8);
  for (int i = 0; i < steps; ++i) {
    const bool cut = random() % 3 == 0;
    Version tool = Version::empty(Store::make(), grid);
    switch (random() % 4) {
      case 0:
        tool = makeSphere(Store::make(), grid, place(16), part(3, 9));
        break;
      case 1:
        tool = makeRod(Store::make(), grid, place(6), place(26), part(1.5, 4));
        break;
      case 2:
        tool = makeTorus(Store::make(), grid, place(10), part(8, 14), part(1.5, 4));
        break;
      default:
        tool = makeBlock(Store::make(), grid, place(14), Vec3d(part(4, 16), part(4, 16), part(4, 16)), part(0, 2));
        break;
    }
    Version next = combine(version, tool, cut ? Combination::cut : Combination::join);
    if (next.stats().bricks > 0) version = std::move(next);
  }
  return version;
}

double meanOf(const std::vector<double>& list) {
  double sum = 0;
  for (const double each : list) sum += each / double(list.size());
  return sum;
}

void tell(BenchReport& report, const char* what, const Totals& totals) {
  report.heading(
      fmt::format("{}: {} of {} refused; at most {} charts, stretch {:.3f} at most, {:.0f} % covered at least; the "
                  "largest deviation "
                  "{:.1f} % of the size",
                  what, totals.refused, totals.models, totals.charts, totals.stretch, 100 * totals.covered,
                  100 * totals.worstShare));
  if (std::vector<double> least = totals.least; !least.empty()) {
    std::sort(least.begin(), least.end());
    report.heading(
        fmt::format("{}: least scaled Jacobian {:.2f} in the median; {} of {} quads below 0.2, none in {} models; {} "
                    "models have fewer than 95 % of the quads that were asked for",
                    what, least[least.size() / 2], totals.bad, totals.quads,
                    std::ranges::count_if(least, [](double each) { return each >= kBadJacobian; }), totals.few));
  }
  if (!totals.rms.empty())
    report.heading(fmt::format(
        "{}, of QuadriFlow's, mean over {} models: irregular {:.2f}, RMS {:.2f}, most {:.2f}, seconds {:.1f}; it "
        "refused {} of {}",
        what, totals.rms.size(), meanOf(totals.irregular), meanOf(totals.rms), meanOf(totals.most),
        meanOf(totals.seconds), totals.peerRefused, totals.peers));
}

void measured(BenchReport& report, const BenchOptions& options, bool faces) {
  const fs::path folder = options.folder.empty() ? fs::temp_directory_path() : options.folder;
  if (!fs::exists(kBlender)) report.heading("cad: without Blender there is no peer");
  if (const char* data = std::getenv("ARGIL_DATA")) {
    const fs::path meshes = fs::path(data) / "mesh";
    if (!fs::is_directory(meshes))
      throw Error(fmt::format("{}: no folder of meshes, though ARGIL_DATA says so", meshes.string()));
    std::vector<fs::path> files;
    for (const auto& each : fs::directory_iterator(meshes)) files.push_back(each.path());
    std::sort(files.begin(), files.end());
    Totals few, more, many;
    for (const fs::path& file : files) {
      const std::optional<Version> clay = closedModel(report, options, file);
      if (!clay) continue;
      const std::string name = file.stem().string();
      quadsOf(report, options, name, *clay, kFewQuads, folder, true, few);
      quadsOf(report, options, name, *clay, kQuads, folder, true, more);
      quadsOf(report, options, name, *clay, kManyQuads, folder, true, many);
      if (!faces) continue;
      facesOf(report, options, name, *clay, kFewQuads);
      facesOf(report, options, name, *clay, 2 * kFewQuads);
    }
    tell(report, "closed meshes, 500 quads", few);
    tell(report, "closed meshes, 2 000 quads", more);
    tell(report, "closed meshes, 10 000 quads", many);
  } else {
    report.heading("cad: set ARGIL_DATA to the folder of test data for real models");
  }
  Totals sculpts;
  for (int i = 0; i < options.sculpts; ++i)
    quadsOf(report, options, fmt::format("sculpt {}", i), randomSculpt(unsigned(i)), kFewQuads, folder, false, sculpts);
  tell(report, "random sculpts, 500 quads", sculpts);
}

}  // namespace

void benchCad(BenchReport& report, const BenchOptions& options) {
  measured(report, options, true);
}

void benchCadQuads(BenchReport& report, const BenchOptions& options) {
  measured(report, options, false);
}

}  // namespace argil::bench
