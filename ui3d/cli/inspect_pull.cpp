#include "ui3d/cli/inspect_pull.h"
#include "engine/document/size_words.h"

#include <fmt/format.h>

#include <algorithm>
#include <charconv>

#include "clay/base/error.h"

namespace argil::cli {

namespace {

constexpr size_t kMostPlaces = 5;  // that are told in words; JSON has all

// Nothing: the best.
std::optional<Vec3d> directionOf(const std::string& text) {
  if (text == "best") return std::nullopt;
  for (int axis = 0; axis < 3; ++axis)
    if (text == std::string(1, char('x' + axis))) return Vec3d::Unit(axis);
  Vec3d pull = Vec3d::Zero();
  const char* at = text.data();
  const char* const end = at + text.size();
  for (int i = 0; i < 3; ++i) {
    const auto read = std::from_chars(at, end, pull[i]);
    const bool last = i == 2;
    if (read.ec != std::errc() || (last ? read.ptr != end : read.ptr == end || *read.ptr != ',')) break;
    at = read.ptr + (last ? 0 : 1);
    if (last && pull.allFinite() && pull.norm() > 1e-9) return pull;
  }
  throw Error(fmt::format("--pull {}: give best, x, y, z or a direction such as 0,0.2,1", text));
}

}  // namespace

bool pullAsked(const InspectOptions& options) {
  if (options.pull.empty()) {
    if (options.draftDegrees) throw Error("--draft goes with --pull");
    return false;
  }
  (void)directionOf(options.pull);
  if (options.draftDegrees && !(*options.draftDegrees >= 0 && *options.draftDegrees <= 45))
    throw Error(fmt::format("--draft {}: give 0 to 45 degrees", *options.draftDegrees));
  return true;
}

engine::PullReport pullOf(const InspectOptions& options, const clay::TriangleMesh& mesh, double unevenMm) {
  return engine::checkPull(mesh, unevenMm, directionOf(options.pull), options.draftDegrees.value_or(2), options.job);
}

void sayPull(const InspectOptions& options, const engine::PullReport& report) {
  const Vec3d& pull = report.pull;
  fmt::print("from a mould, pulled along ({:.3f}, {:.3f}, {:.3f}){}\n", pull.x(), pull.y(), pull.z(),
             options.pull == "best" ? ", where least is undercut" : "");
  fmt::print("  undercuts   {}, {:.2g} % of the surface\n",
             report.undercuts.empty()
                 ? "none"
                 : fmt::format("{}, {} mm²", report.undercuts.size(), engine::figure(report.undercutMm2, 4)),
             100 * report.undercutMm2 / report.areaMm2);
  for (size_t i = 0; i < std::min(kMostPlaces, report.undercuts.size()); ++i) {
    const engine::Undercut& each = report.undercuts[i];
    fmt::print("              {} mm² at ({:.1f}, {:.1f}, {:.1f})\n", engine::figure(each.areaMm2), each.atMm.x(),
               each.atMm.y(), each.atMm.z());
  }
  fmt::print("  draft       {} mm² have less than {:g}°, {:.2g} % of the surface\n", engine::figure(report.steepMm2, 4),
             options.draftDegrees.value_or(2), 100 * report.steepMm2 / report.areaMm2);
}

nlohmann::ordered_json pullJson(const engine::PullReport& report) {
  nlohmann::ordered_json json{{"pull", {report.pull.x(), report.pull.y(), report.pull.z()}},
                              {"area_mm2", report.areaMm2},
                              {"undercut_mm2", report.undercutMm2},
                              {"little_draft_mm2", report.steepMm2},
                              {"undercuts", nlohmann::ordered_json::array()}};
  for (const engine::Undercut& each : report.undercuts)
    json["undercuts"].push_back({{"at_mm", {each.atMm.x(), each.atMm.y(), each.atMm.z()}}, {"area_mm2", each.areaMm2}});
  return json;
}

}  // namespace argil::cli
