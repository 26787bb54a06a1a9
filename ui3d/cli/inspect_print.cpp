#include "ui3d/cli/inspect_print.h"
#include "engine/document/size_words.h"

#include <fmt/format.h>

#include "clay/base/error.h"
#include "io/bytes/input.h"

namespace argil::cli {

namespace {

constexpr size_t kMostPlaces = 5;  // of a kind that are told in words; JSON has all

std::string at(const Vec3d& p) {
  return fmt::format("({:.1f}, {:.1f}, {:.1f})", p.x(), p.y(), p.z());
}

void sayWalls(const char* what, const char* beyond, const clay::ThinParts& walls, double limit) {
  if (walls.parts.empty()) {
    fmt::print("  {:<11} none {} than {:g} mm\n", what, beyond, limit);
    return;
  }
  fmt::print("  {:<11} {} {} than {:g} mm, {:.2g} % of the surface\n", what, walls.parts.size(), beyond, limit,
             100 * walls.share());
  for (size_t i = 0; i < std::min(kMostPlaces, walls.parts.size()); ++i) {
    const clay::ThinPart& part = walls.parts[i];
    fmt::print("              {:.2g} mm at {}, {} mm²\n", part.leastMm, at(part.atMm), engine::figure(part.areaMm2));
  }
}

nlohmann::ordered_json wallsJson(const clay::ThinParts& walls, double limit) {
  nlohmann::ordered_json json{
      {"limit_mm", limit}, {"share_beyond", walls.share()}, {"parts", nlohmann::ordered_json::array()}};
  for (const clay::ThinPart& part : walls.parts) {
    const Vec3d& p = part.atMm;
    json["parts"].push_back({{"least_mm", part.leastMm}, {"at_mm", {p.x(), p.y(), p.z()}}, {"area_mm2", part.areaMm2}});
  }
  return json;
}

}  // namespace

std::optional<engine::PrintProcess> printOf(const InspectOptions& options) {
  if (options.print.empty()) {
    if (options.wallMm || options.gapMm || options.outletMm) throw Error("--wall, --gap and --outlet go with --print");
    return std::nullopt;
  }
  engine::PrintProcess process = engine::printProcess(options.print);
  const auto take = [](const char* name, const std::optional<double>& given, double& limit) {
    if (!given) return;
    if (!(*given > 0 && *given <= 1000)) throw Error(fmt::format("{} {}: give 0 to 1000 mm", name, *given));
    limit = *given;
  };
  take("--wall", options.wallMm, process.wallMm);
  take("--gap", options.gapMm, process.gapMm);
  take("--outlet", options.outletMm, process.outletMm);
  return process;
}

void sayPrint(const engine::PrintProcess& process, const engine::PrintReport& report) {
  fmt::print("printed in {}, as it stands\n", process.name);
  sayWalls("walls", "thinner", report.walls, process.wallMm);
  sayWalls("gaps", "narrower", report.gaps, process.gapMm);
  if (process.needsSupport) {
    fmt::print("  overhangs   {} mm² look down and are flatter than {:g}°{}\n", engine::figure(report.overhangMm2, 4),
               process.overhangDegrees,
               report.overhangMm2 > 0 && !report.overhangs ? ", in spots that need no support" : "");
    fmt::print("  islands     {}\n",
               report.slices.islands.empty() ? "none" : std::to_string(report.slices.islands.size()));
    for (size_t i = 0; i < std::min(kMostPlaces, report.slices.islands.size()); ++i) {
      const clay::Island& island = report.slices.islands[i];
      fmt::print("              at {}, {}\n", at(island.at),
                 island.aloneMm > 0 ? fmt::format("alone for {:.3g} mm", island.aloneMm) : "a body of its own");
    }
  }
  double closed = 0, open = 0;
  for (const clay::Trap& trap : report.slices.traps) (trap.closed ? closed : open) += trap.volumeMm3;
  if (closed > 0 || open > 0)
    fmt::print("  hollows     {} mm³ closed, {} mm³ that hold a liquid{}\n", engine::figure(closed, 4),
               engine::figure(open, 4), process.holdsLiquid ? "" : ", which does not matter here");
  else
    fmt::print("  hollows     none that hold a liquid\n");
  for (size_t i = 0; i < std::min(kMostPlaces, report.slices.traps.size()); ++i) {
    const clay::Trap& trap = report.slices.traps[i];
    fmt::print("              {} mm³ from {} up{}\n", engine::figure(trap.volumeMm3, 4), at(trap.at),
               trap.closed ? ", closed" : fmt::format(" to z = {:.1f}", trap.spillsMm));
  }
  if (process.outletMm > 0) {
    if (report.necks.empty())
      fmt::print("  ways out    no hollow opens by less than {:g} mm\n", process.outletMm);
    else
      fmt::print("  ways out    {} hollow{} by less than {:g} mm\n", report.necks.size(),
                 report.necks.size() == 1 ? " opens" : "s open", process.outletMm);
    for (size_t i = 0; i < std::min(kMostPlaces, report.necks.size()); ++i) {
      const clay::Neck& neck = report.necks[i];
      fmt::print("              {:.2g} mm at {}, from {}\n", 2 * neck.radiusMm, at(neck.atMm), at(neck.hollowMm));
    }
  }
  const Vec3d& bed = process.bedMm;
  fmt::print("  bed         it {} on {:g} × {:g} × {:g} mm\n", report.fits ? "fits" : "does not fit", bed.x(), bed.y(),
             bed.z());
  const int troubles = report.troubles(process);
  fmt::print("  {}\n", troubles == 0 ? "nothing stands in the way"
                                     : fmt::format("{} kind{} of trouble", troubles, troubles == 1 ? "" : "s"));
}

nlohmann::ordered_json printJson(const engine::PrintProcess& process, const engine::PrintReport& report) {
  nlohmann::ordered_json json{{"process", process.id},
                              {"walls", wallsJson(report.walls, process.wallMm)},
                              {"gaps", wallsJson(report.gaps, process.gapMm)},
                              {"overhang_mm2", report.overhangMm2},
                              {"overhang_needs_support", report.overhangs},
                              {"fits", report.fits},
                              {"islands", nlohmann::ordered_json::array()},
                              {"traps", nlohmann::ordered_json::array()},
                              {"necks", nlohmann::ordered_json::array()},
                              {"troubles", report.troubles(process)}};
  for (const clay::Island& island : report.slices.islands)
    json["islands"].push_back({{"at_mm", {island.at.x(), island.at.y(), island.at.z()}}, {"alone_mm", island.aloneMm}});
  for (const clay::Trap& trap : report.slices.traps)
    json["traps"].push_back({{"at_mm", {trap.at.x(), trap.at.y(), trap.at.z()}},
                             {"volume_mm3", trap.volumeMm3},
                             {"closed", trap.closed},
                             {"spills_mm", trap.spillsMm}});
  for (const clay::Neck& neck : report.necks)
    json["necks"].push_back({{"at_mm", {neck.atMm.x(), neck.atMm.y(), neck.atMm.z()}},
                             {"wide_mm", 2 * neck.radiusMm},
                             {"hollow_mm", {neck.hollowMm.x(), neck.hollowMm.y(), neck.hollowMm.z()}}});
  return json;
}

Meetings meetings(const engine::Document& document, double gapMm, Job* job) {
  Meetings result;
  std::vector<engine::PlacedClay> placed;
  for (const engine::Piece& piece : document.pieces) {
    if (!piece.visible) continue;
    result.names.push_back(piece.name);
    placed.push_back({piece.version, piece.pose});
  }
  result.found = engine::piecesThatMeet(placed, gapMm, job);
  return result;
}

void sayMeetings(const Meetings& meetings, double gapMm) {
  if (meetings.names.size() < 2) return;
  if (meetings.found.empty()) {
    fmt::print("pieces        none meet or are nearer to another than {:g} mm\n", gapMm);
    return;
  }
  for (const engine::PiecesMeet& each : meetings.found) {
    const std::string how = each.overlap   ? fmt::format("overlap, {:.2g} mm deep", each.mm)
                            : each.mm == 0 ? std::string("touch")
                                           : fmt::format("are {:.2g} mm apart", each.mm);
    fmt::print("pieces        {} and {} {} at {}\n", io::displayName(meetings.names[each.first]),
               io::displayName(meetings.names[each.second]), how, at(each.atMm));
  }
}

nlohmann::ordered_json meetingsJson(const Meetings& meetings) {
  nlohmann::ordered_json json = nlohmann::ordered_json::array();
  for (const engine::PiecesMeet& each : meetings.found) {
    const Vec3d& p = each.atMm;
    json.push_back({{"pieces", {meetings.names[each.first], meetings.names[each.second]}},
                    {"overlap", each.overlap},
                    {"mm", each.mm},
                    {"at_mm", {p.x(), p.y(), p.z()}}});
  }
  return json;
}

}  // namespace argil::cli
