#include "bench/export/print_peers.h"

#include <fmt/format.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "bench/export/closed_model.h"
#include "clay/mesh/reduce.h"
#include "clay/surface/surface.h"
#include "clay/whole/offset.h"
#include "engine/print/nest.h"
#include "engine/print/print_check.h"
#include "engine/saving/session.h"
#include "io/bytes/child_process.h"
#include "io/models/mesh_writer.h"

namespace argil::bench {

namespace {

using namespace clay;
namespace fs = std::filesystem;

constexpr int kRuns = 5;
constexpr double kWallMm = 1, kShellMm = 2.4, kGapMm = 3;
constexpr double kNarrowMm = 4;  // twice PrusaSlicer's closing distance when left as it is
constexpr size_t kCopies = 150;  // more than a bed holds
constexpr const char *kBlender = "/usr/bin/blender", *kSlicer = "/usr/bin/prusa-slicer";

// Looks for walls under so many mm in the first file and writes what it found, and in how many seconds, to the second.
constexpr const char* kToolbox = R"(
import bpy, addon_utils, json, sys, time
source, wall, told = sys.argv[sys.argv.index('--') + 1:]
bpy.ops.wm.read_factory_settings(use_empty=True)
addon_utils.enable('object_print3d_utils')
bpy.ops.import_mesh.stl(filepath=source)
bpy.context.view_layer.objects.active = bpy.context.selected_objects[0]
bpy.context.scene.print_3d.thickness_min = float(wall)
start = time.time()
bpy.ops.mesh.print3d_check_thick()
seconds = time.time() - start
from object_print3d_utils import report
json.dump({'seconds': seconds, 'thin': len(report.info()[0][1][1])}, open(told, 'w'))
)";

// Seconds from the start of a program to its end; none where it fails.
std::optional<double> secondsOf(const char* program, const std::vector<std::string>& arguments) {
  const Stopwatch watch;
  io::ChildProcess process(program, arguments, {});
  return process.wait() == 0 ? std::optional(watch.us() / 1e6) : std::nullopt;
}

// Walls thinner than kWallMm: what we say of them beside what the Toolbox does.
void walls(BenchReport& report, const BenchOptions& options, const std::string& name, const Version& clay,
           const fs::path& stl, const fs::path& folder) {
  engine::PrintProcess process = engine::printProcess("sla");
  process.wallMm = kWallMm;
  Samples times;
  engine::PrintReport found;
  for (int i = 0; i < kRuns; ++i) {
    const Stopwatch watch;
    found = engine::checkPrint(clay, {}, process, options.job);
    times.add(watch.us());
  }
  BenchResult result = times.result("print/checks/" + name);
  result.threads = engine::Session::strokeThreads();
  result.note = fmt::format("all checks; {} walls under {:g} mm", found.walls.parts.size(), kWallMm);
  if (fs::exists(kBlender)) {
    const fs::path script = folder / "toolbox.py", told = folder / "toolbox.json";
    std::ofstream(script) << kToolbox;
    fs::remove(told);
    (void)secondsOf(kBlender, {"-b", "--factory-startup", "-P", script.string(), "--", stl.string(),
                               fmt::format("{:g}", kWallMm), told.string()});
    std::ifstream file(told);
    const nlohmann::json said = nlohmann::json::parse(file, nullptr, false);
    if (!said.is_discarded()) {
      result.peer = 1e6 * said.value("seconds", 0.0);
      result.peerName = "3D-Print Toolbox, walls alone";
      result.note += fmt::format(", it says {} faces are", said.value("thin", size_t{0}));
    } else {
      result.note += "; the Toolbox said nothing";
    }
  }
  report.add(result);
}

// A wall of kShellMm around it: what slicing takes longer with it, for the slicer.
void hollowing(BenchReport& report, const BenchOptions& options, const std::string& name, const Version& clay,
               const fs::path& stl, const fs::path& folder) {
  Samples times;
  Version hollow = clay;
  for (int i = 0; i < kRuns; ++i) {
    const Stopwatch watch;
    hollow = shell(clay, kShellMm, 0, engine::Session::strokeThreads(), options.job, kNarrowMm);
    times.add(watch.us());
  }
  BenchResult result = times.result("print/hollow/" + name);
  result.threads = engine::Session::strokeThreads();
  engine::PrintProcess process = engine::printProcess("sla");
  const double least = kShellMm - 0.1 * clay.grid().voxelMm;
  process.wallMm = least;
  const size_t thin = engine::checkPrint(hollow, {}, process, options.job).walls.parts.size(),
               before = engine::checkPrint(clay, {}, process, options.job).walls.parts.size();
  result.note = fmt::format("{} walls under {:.4g} mm, {} in the solid", thin, least, before);
  if (fs::exists(kSlicer)) {
    const auto sliced = [&](bool hollowed) {
      std::vector<std::string> words{"--export-sla",           "--supports-enable=0",    "--pad-enable=0",
                                     "--layer-height=0.1",     "--max-print-height=400", "--bed-shape",
                                     "0x0,250x0,250x210,0x210"};
      if (hollowed)
        words.insert(words.end(), {"--hollowing-enable", fmt::format("--hollowing-min-thickness={:g}", kShellMm)});
      words.insert(words.end(), {stl.string(), "--output", (folder / "sliced.sl1").string()});
      return secondsOf(kSlicer, words);
    };
    const std::optional<double> with = sliced(true), without = sliced(false);
    if (with && without) {
      result.peer = 1e6 * (*with - *without);
      result.peerName = "PrusaSlicer, with it less without";
    } else {
      result.note += "; PrusaSlicer did not slice it";
    }
  }
  report.add(result);
}

// How many have a place on one bed.
void nesting(BenchReport& report, const BenchOptions& options, const std::string& name, const TriangleMesh& mesh,
             const fs::path& folder) {
  std::vector<engine::Vec2d> footprint;
  for (const Vec3d& p : mesh.positions) footprint.emplace_back(p.head<2>());
  const std::vector<std::vector<engine::Vec2d>> many(kCopies, footprint);
  const engine::NestOptions how{.gapMm = kGapMm};
  const Stopwatch watch;
  const std::vector<engine::Nested> nested = engine::nest(many, how, WorkPart(options.job));
  BenchResult result;
  result.name = "print/nest/" + name;
  result.unit = "on a bed";
  result.n = 1;
  result.median = double(std::ranges::count(nested, 0, &engine::Nested::bed));
  result.note =
      fmt::format("250 × 210 mm, gaps of {:g} mm; {} laid in {:.1f} s", kGapMm, many.size(), watch.us() / 1e6);
  if (fs::exists(kSlicer)) {
    const fs::path in = folder / "nest.stl", out = folder / "nest.3mf";
    io::writeMesh(in, reduce(mesh, {.triangles = 20000, .errorMm = {}}, options.job).mesh);
    const auto fit = [&](int count) {
      fs::remove(out);
      (void)secondsOf(kSlicer, {"--export-3mf", "--duplicate", std::to_string(count), "--duplicate-distance",
                                fmt::format("{:g}", kGapMm), "--bed-shape", "0x0,250x0,250x210,0x210", in.string(),
                                "--output", out.string()});
      return fs::exists(out);
    };
    int least = 0, most = 256;
    while (most - least > 1) (fit((least + most) / 2) ? least : most) = (least + most) / 2;
    result.peer = least;
    result.ratio = least > 0 ? result.median / least : 0;
    result.peerName = "PrusaSlicer";
  }
  report.add(result);
}

}  // namespace

void benchPrintPeers(BenchReport& report, const BenchOptions& options) {
  const char* data = std::getenv("ARGIL_DATA");
  if (data == nullptr) {
    report.heading("print: set ARGIL_DATA to the folder of test data for real models");
    return;
  }
  report.heading("Models of 100 mm, voxels of 0.25 mm, beside the programs that people use today");
  if (!fs::exists(kBlender)) report.heading("print: without Blender there is no Toolbox");
  if (!fs::exists(kSlicer)) report.heading("print: without PrusaSlicer nothing is beside hollowing and nesting");
  const fs::path folder = options.folder.empty() ? fs::temp_directory_path() : options.folder;
  for (const char* file : {"koala_100k.obj", "fandisk.obj"}) {
    const std::optional<Version> clay = closedModel(report, options, fs::path(data) / "mesh" / file);
    if (!clay) continue;
    const std::string name = fs::path(file).stem().string();
    Surface surface(false, Grade::fine);
    (void)surface.update(*clay);
    const TriangleMesh mesh = surface.toMesh();
    const fs::path stl = folder / "print-peer.stl";
    io::writeMesh(stl, mesh);
    walls(report, options, name, *clay, stl, folder);
    hollowing(report, options, name, *clay, stl, folder);
    nesting(report, options, name, mesh, folder);
  }
}

}  // namespace argil::bench
