// What tools, operations and hands make of clay, held against figures that were kept. The tables of tools and
// operations are walked, each parameter once by itself, so a new row has its figures too.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/offset.h"
#include "engine/models/prepare_clay.h"
#include "engine/session/run.h"
#include "engine/tools/piece_jobs.h"
#include "engine/tools/tool_table.h"
#include "tests/figures/kept_figures.h"
#include "tests/support/tool_files.h"

namespace argil::engine {
namespace {

using clay::Version;
using tests::KeptFigures;

std::filesystem::path keptIn(const std::string& name) {
  return std::filesystem::path(ARGIL_SOURCE_DIR) / "tests/figures" / name;
}

// A number between −1 and 1 for each voxel and `kind`, without order.
double weightOf(Coord voxel, uint64_t kind) {
  uint64_t h = kind * 0x9e3779b97f4a7c15u;
  for (const int c : {voxel.x, voxel.y, voxel.z}) {
    h = (h ^ uint64_t(uint32_t(c))) * 0xbf58476d1ce4e5b9u;
    h ^= h >> 29;
  }
  return double(h >> 11) * 0x1p-52 - 1;
}

// Bricks; of the distances the mean and two sums by weights that tell where they are; the same of each channel that is
// there.
void add(const Version& version, std::vector<double>& figures) {
  double bricks = 0, mean = 0;
  std::array<double, 2> sums{};
  version.forEachBrick([&](const clay::Brick& brick) {
    ++bricks;
    for (int v = 0; v < clay::kBrickVoxels; ++v) {
      const double phi = brick.phi(v);
      const Coord voxel = brick.coord * clay::kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
      mean += phi;
      for (size_t k = 0; k < sums.size(); ++k) sums[k] += phi * weightOf(voxel, k + 1);
    }
  });
  const double voxels = std::max(bricks, 1.0) * clay::kBrickVoxels;
  // Sums by weights grow with the root of the voxels.
  figures.insert(figures.end(), {bricks, mean / voxels, sums[0] / std::sqrt(voxels), sums[1] / std::sqrt(voxels)});
  for (const clay::Channel channel : clay::kAllChannels) {
    if (!version.has(channel)) continue;
    double all = 0, sum = 0;
    version.forEachBrick([&](const clay::Brick& brick) {
      const clay::ChannelSlot slot = version.find(channel, brick.coord);
      for (int v = 0; v < clay::kBrickVoxels; ++v) {
        const Coord voxel = brick.coord * clay::kBrickEdge + Coord{v >> 6, (v >> 3) & 7, v & 7};
        all += slot.value(v) / 255.0;
        sum += slot.value(v) / 255.0 * weightOf(voxel, 3);
      }
    });
    figures.insert(figures.end(), {all / voxels, sum / std::sqrt(voxels)});
  }
}

// Another value than the row begins with.
template <class Owner>
double anotherValue(const Parameter<Owner>& parameter) {
  const double low = parameter.low, high = parameter.high, standard = parameter.standard;
  if (parameter.unit == "colour") return 0x3b5bd0;
  if (parameter.unit == "on" || !parameter.choices.empty()) return standard == low ? low + 1 : low;
  if (standard == 0) return std::min(high, parameter.unit == "%" ? 20.0 : parameter.unit == "°" ? 30.0 : 0.6);
  return std::clamp(0.7 * standard, low, high);
}

// Where a stroke goes on the clay of figures, with pressure and the stylus's turn.
std::vector<PathPoint> pathAround(double radiusMm, bool turned) {
  std::vector<PathPoint> path;
  for (int i = 0; i <= 10; ++i) {
    const double angle = 0.15 * i, lift = 0.3 * std::sin(0.9 * i);
    PathPoint point;
    point.timeS = 0.03 * i;
    point.mm = (radiusMm + lift) * Vec3d(std::cos(angle) * std::cos(0.4 + 0.05 * i),
                                         std::sin(angle) * std::cos(0.4 + 0.05 * i), std::sin(0.4 + 0.05 * i));
    point.pressure = 0.35 + 0.06 * i;
    if (turned)
      point.rotation =
          Eigen::AngleAxisd(0.2 * i, Vec3d(0.3, -0.5, 0.8).normalized()) * Eigen::AngleAxisd(0.7, Vec3d::UnitX());
    path.push_back(point);
  }
  return path;
}

void stroke(Session& session, const Tool& tool, const std::vector<PathPoint>& path, const StrokeImages& images = {}) {
  session.beginStroke(tool, images);
  for (const PathPoint& point : path) session.addPoint(point);
  session.endStroke();
}

Tool toolOf(std::string_view id, double radiusMm) {
  Tool tool = scriptTool(*findTool(id));
  tool.radiusMm = radiusMm;
  tests::giveFile(tool);
  return tool;
}

// A ball with a groove, a bump, two colours, another material and a masked part.
Document figureClay() {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  grid.originMm = Vec3d(0.13, -0.21, 0.08);
  Session session(Document::of(clay::makeSphere(clay::Store::make(), grid, Vec3d(0.3, -0.2, 0.1), 7)));
  stroke(session, toolOf("carve", 1.5), {{0, {0, 2, 7}}, {0.1, {6, 1, 3}}});
  stroke(session, toolOf("add", 2), {{0, {5, 4, 2}}});
  Tool paint = toolOf("paint", 3);
  paint.colour = 0x2060c0;
  stroke(session, paint, {{0, {4, 0, 6}}, {0.1, {2, 6, 4}}});
  stroke(session, toolOf("material", 2.5), {{0, {6, 2, 2}}});
  stroke(session, toolOf("mask", 2), {{0, {3, 5, 4}}});
  Document document = *session.document();
  document.pieces[0].materials.resize(2);
  document.pieces[0].materials[0].name = "Chalk";
  document.pieces[0].materials[1].name = "Wax";
  Piece other;
  other.name = "Other";
  grid.voxelMm = 0.4;
  other.version = clay::makeBlock(clay::Store::make(), grid, Vec3d::Zero(), {9, 7, 5}, 1);
  other.pose.translation = Vec3d(4, 5, 2);
  other.pose.rotation = Eigen::AngleAxisd(0.6, Vec3d(1, 2, 3).normalized());
  document.add(std::move(other));
  return document;
}

TEST(Figures, EveryToolMakesWhatItMade) {
  KeptFigures kept(keptIn("tool.txt"));
  const Document clay = figureClay();
  std::vector<double> begun;
  add(clay.pieces[0].version, begun);
  kept.expect("begun", begun);
  const auto draw = [&](const std::string& name, const Tool& tool, bool turned, const StrokeImages& images = {}) {
    Session session(clay);
    stroke(session, tool, pathAround(6.7, turned), images);
    std::vector<double> figures;
    add(session.version(), figures);
    kept.expect(name, figures);
  };
  for (const ToolRow& row : toolTable()) {
    const std::string id(row.id);
    draw(id, toolOf(id, 2), false);
    draw(id + "/large-turned", toolOf(id, 4.5), true);
    if (row.opposite == row.id || row.opposite.empty()) {
      Tool inverted = toolOf(id, 2);
      inverted.inverted = true;
      draw(id + "/inverted", inverted, false);
    }
    StrokeImages images;
    images.mirrors.push_back({Vec3d(0.2, 0.1, 0), Vec3d(1, -0.5, 0.1)});
    images.turns = 3;
    images.axis = Vec3d(0.1, 0.2, 1);
    draw(id + "/images", toolOf(id, 2), false, images);
    for (const Parameter<Tool>& parameter : row.parameters) {
      if (parameter.id == "radius") continue;
      Tool tool = toolOf(id, 2);
      parameter.change(tool, anotherValue(parameter));
      draw(id + "/" + std::string(parameter.id), tool, true);
    }
  }
}

TEST(Figures, EveryOperationMakesWhatItMade) {
  KeptFigures kept(keptIn("operation.txt"));
  const Document whole = figureClay();
  Document hollow = whole;
  hollow.pieces[0].version = clay::shell(hollow.pieces[0].version, 2, 0);
  const auto run = [&](const std::string& name, const PieceJob& row, PieceArguments arguments) {
    const Document& clay = row.id == "infill" || row.id == "drain" ? hollow : whole;
    if (row.pieces == 2) arguments.pieces = {clay.pieces[0].id, clay.pieces[1].id};
    arguments.plane = {Vec3d(1, 0.5, 0.2), Vec3d(0.3, 0.2, 1)};
    arguments.directionMm = Vec3d(0.1, 0.2, -1);
    if (row.takesBox) {
      // A box around the ball, its points pushed to and fro.
      auto& lattice = arguments.change<LatticeValues>();
      lattice.boxMm = {Vec3d::Constant(-12), Vec3d::Constant(12)};
      const std::array<int, 3> n = lattice.counts;
      for (int x = 0; x < n[0]; ++x)
        for (int y = 0; y < n[1]; ++y)
          for (int z = 0; z < n[2]; ++z)
            arguments.pointsMm.push_back(
                Vec3d(-12 + 24.0 * x / (n[0] - 1), -12 + 24.0 * y / (n[1] - 1), -12 + 24.0 * z / (n[2] - 1)) +
                1.5 * Vec3d(weightOf({x, y, z}, 1), weightOf({x, y, z}, 2), weightOf({x, y, z}, 3)));
    } else if (row.takesCurve) {
      arguments.pointsMm = {{-14, -3, 20}, {-4, 2, 20}, {5, -1, 20}, {14, 4, 20}};
      if (row.group == "Mask") {
        arguments.pointsMm.insert(arguments.pointsMm.end(), {{10, 12, 20}, {-9, 11, 20}});
        arguments.closed = true;
      }
    }
    std::vector<double> figures;
    PieceResult result;
    try {
      result = runPieceJob(row, clay, arguments);
    } catch (const Error&) {
      return kept.expect(name, {-1});  // A wall below two voxels: refused.
    }
    Document after = clay;
    applyPieceResult(result, clay, after);
    for (const Piece& piece : after.pieces) {
      add(piece.version, figures);
      const Vec3d corner = piece.pose.apply(Vec3d(1, 2, 3));
      figures.insert(figures.end(), {corner.x(), corner.y(), corner.z(), double(piece.materials.size())});
    }
    // Figures that a person is told.
    for (const std::string& note : result.notes)
      for (size_t i = 0; i < note.size();) {
        char* end = nullptr;
        const bool digit = std::isdigit(static_cast<unsigned char>(note[i])) != 0;
        if (digit) figures.push_back(std::strtod(&note[i], &end));
        i = digit ? size_t(end - note.data()) : i + 1;
      }
    kept.expect(name, figures);
  };
  for (const PieceJob& row : pieceJobs()) {
    const std::string id(row.id);
    PieceArguments standard = standardArguments(row, whole);
    run(id, row, standard);
    if (row.takesCurve && !row.takesBox) {
      PieceArguments arguments = standard;
      arguments.closed = true;
      if (row.group != "Mask") run(id + "/closed", row, arguments);
    }
    for (const Parameter<PieceArguments>& parameter : row.parameters) {
      PieceArguments arguments = standard;
      parameter.change(arguments, anotherValue(parameter));
      run(id + "/" + std::string(parameter.id), row, arguments);
    }
  }
}

// A simulated hand, device and servo, in virtual time: what is cut follows from all that is felt.
TEST(Figures, EveryHandMakesWhatItMade) {
  KeptFigures kept(keptIn("hand.txt"));
  const auto run = [&](const std::string& name, const std::string& setup, const std::string& stroke,
                       const std::string& device = "touch") {
    const Script script = parseScript(
        R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.5}, {"block": {"size_mm": [30, 24, 12], "round_mm": 2}})" +
            setup + R"(], "strokes": [)" + stroke + "]}",
        name);
    Session session(prepareClay(clay::Store::make(), script).version);
    clay::Surface surface;
    RunOptions options;
    options.device = device;
    const RunReport report = runScript(session, surface, script, options);
    ASSERT_TRUE(report.servo) << name;
    const ServoReport& servo = *report.servo;
    std::vector<double> figures{double(servo.ticks),   double(servo.cutting), double(servo.touching),
                                double(servo.clamped), double(servo.slewed),  double(servo.stopped),
                                servo.peakForceN,      double(report.stamps), double(report.versions)};
    add(session.version(), figures);
    kept.expect(name, figures);
  };
  // Into the top, along it and out; the path beyond the clay's edge.
  const auto path = [](const std::string& tool, const std::string& more = {}) {
    return R"({"tool": ")" + tool + R"(", "radius_mm": 2.5, "drive": "hand", )" + more +
           R"("path": [[0,-10,-4,12],[0.2,-10,-4,7],[0.6,4,3,6.5],[0.8,17,4,4],[0.9,17,4,12]]})";
  };
  for (const ToolRow& row : toolTable())
    if (row.file == ToolFile::none) run(std::string(row.id), "", path(std::string(row.id)));
  for (const char* device : {"touchx", "premium15", "falcon"})
    run(std::string("device/") + device, "", path("carve"), device);
  run("strength", "", path("smooth", R"("strength": 0.9, "pressure_is_force": true, "full_force_n": 1, )"));
  const auto material = [&](const std::string& name, const std::string& text) {
    run("material/" + name, R"(, {"material": {)" + text + "}}", path("carve"));
    run("material-rubbed/" + name, R"(, {"material": {)" + text + "}}", path("smooth"));
  };
  material("stiff", R"("stiffness_nmm": 0.3)");
  material("hard", R"("hardness_nmm2": 0.4)");
  material("viscous", R"("viscosity_nsmm": 0.2)");
  material("drag", R"("drag_nsmm": 0.05)");
  material("rough", R"("static_friction": 0.8, "dynamic_friction": 0.4)");
  material("sticky", R"("viscous_friction_nsmm": 0.05)");
  const std::pair<const char*, const char*> guides[] = {
      {"lock_to_point", R"("at": [-3, 0, 6])"},
      {"lock_to_line", R"("at": [0, 1, 6], "direction": [1, 0.2, 0.1])"},
      {"lock_to_plane", R"("at": [0, 0, 7], "direction": [0.1, 0, 1])"},
      {"lock_to_curve", R"("points": [[-12, -2, 7], [0, 4, 6], [12, 0, 7]])"},
      {"lock_to_normal", ""},
      {"keep_out_box", R"("at": [2, 0, 6], "size_mm": [6, 6, 6])"},
      {"keep_out_ball", R"("at": [2, 0, 6], "radius_mm": 4)"},
      {"keep_out_ball", R"("at": [0, 0, 6], "radius_mm": 9, "inside": true)"},
      {"keep_out_plane", R"("at": [0, 0, 7.5], "direction": [0, 0, 1])"},
      {"well_at_points", R"("points": [[0, 2, 7], [8, 4, 7]], "range_mm": 4, "force_n": 1)"},
      {"well_at_curve",
       R"("points": [[-12, -2, 7], [0, 4, 6], [12, 0, 7]], "range_mm": 3, "force_n": 1, "closed": true)"},
      {"well_at_plane", R"("at": [0, 0, 7], "direction": [0, 0.1, 1], "range_mm": 3, "force_n": 1)"},
      {"well_at_clay", R"("range_mm": 3, "force_n": 0.8)"},
      {"gravity", R"("direction": [0, 0.3, -1], "force_n": 0.5)"},
      {"buoyancy", R"("at": [0, 0, 9], "direction": [0, 0, 1], "depth_mm": 4, "force_n": 0.7)"},
      {"viscosity", R"("drag_nsmm": 0.003)"},
      {"ambient_plane", R"("at": [0, 0, 8], "direction": [0, 0.1, 1], "force_n": 1, "stiffness_nmm": 0.2)"},
  };
  for (size_t i = 0; i < std::size(guides); ++i) {
    const auto& [kind, keys] = guides[i];
    const std::string guide =
        std::string(R"(, {"guides": [{"guide": ")") + kind + "\"" + (*keys ? ", " : "") + keys + "}]}";
    run("guide/" + std::to_string(i) + "/" + kind, guide, path("carve"));
    run("guide-rubbed/" + std::to_string(i) + "/" + kind, guide, path("smooth"));
  }
}

}  // namespace
}  // namespace argil::engine
