// What stands in the way of printing the active piece: looked for beside the studio whenever the clay has rested.

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "clay/base/error.h"
#include "clay/surface/surface.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"
#include "ui3d/studio/view/camera.h"

namespace argil::studio {
namespace {

using engine::PrintProcess;
using engine::PrintReport;

constexpr double kRestS = 0.4;      // of the clay, before it is looked at
constexpr size_t kMostPlaces = 12;  // of a kind that are listed
constexpr double kLookMm = 6;       // around a place that the camera goes to
constexpr double kUneven = 0.1;     // voxels that a wall may be uneven by and is no undercut

PrintProcess processOf(const PrintChoice& choice) {
  PrintProcess process = engine::printProcesses()[size_t(choice.process)];
  process.wallMm = choice.wallMm;
  process.gapMm = choice.gapMm;
  process.outletMm = choice.outletMm;
  process.bedMm = choice.bedMm;
  return process;
}

// Zero: the best pull, which is to be found.
std::optional<engine::DraftLimit> draftOf(const PrintChoice& choice) {
  if (choice.pull == 0) return std::nullopt;
  return engine::DraftLimit{
      choice.pull == PrintChoice::kBestPull ? Vec3d(Vec3d::Zero()) : Vec3d(Vec3d::Unit(choice.pull - 1)),
      choice.draftDegrees};
}

// What is in the way of a mould, of the piece as it lies.
engine::PullReport pulled(const clay::Version& version, const haptics::Pose& pose, const engine::DraftLimit& draft,
                          Job& job) {
  clay::Surface surface(false);
  surface.update(version);
  std::optional<Vec3d> along;
  if (!draft.pull.isZero(0)) along = Vec3d(pose.rotation.conjugate() * draft.pull);
  engine::PullReport report =
      engine::checkPull(surface.toMesh(), kUneven * version.grid().voxelMm, along, draft.degrees, &job);
  report.pull = pose.rotation * report.pull;
  for (engine::Undercut& each : report.undercuts) each.atMm = pose.apply(each.atMm);
  return report;
}

bool alike(const PrintProcess& a, const PrintProcess& b) {
  return a.id == b.id && a.wallMm == b.wallMm && a.gapMm == b.gapMm && a.outletMm == b.outletMm && a.bedMm == b.bedMm;
}
bool alike(const haptics::Pose& a, const haptics::Pose& b) {
  return a.translation == b.translation && a.rotation.coeffs() == b.rotation.coeffs();
}

std::vector<std::pair<const void*, haptics::Pose>> aroundOf(const engine::Document& document) {
  std::vector<std::pair<const void*, haptics::Pose>> around;
  for (const engine::Piece& each : document.pieces)
    if (each.visible && each.id != document.active) around.emplace_back(each.version.record(), each.pose);
  return around;
}

bool alike(const std::vector<std::pair<const void*, haptics::Pose>>& a,
           const std::vector<std::pair<const void*, haptics::Pose>>& b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](const auto& x, const auto& y) { return x.first == y.first && alike(x.second, y.second); });
}

// The active piece first, then those around it.
struct Around {
  explicit Around(const engine::Document& document) {
    for (const bool active : {true, false})
      for (const engine::Piece& each : document.pieces) {
        if (active != (each.id == document.active) || !(active || each.visible)) continue;
        pieces.push_back({each.version, each.pose});
        names.push_back(each.name);
      }
  }
  [[nodiscard]] std::vector<std::pair<std::string, engine::PiecesMeet>> meets(double gapMm, Job& job) const {
    std::vector<std::pair<std::string, engine::PiecesMeet>> all;
    for (const engine::PiecesMeet& each : engine::piecesThatMeet(pieces, gapMm, &job, 0))
      all.emplace_back(names[each.second], each);
    return all;
  }
  std::vector<engine::PlacedClay> pieces;
  std::vector<std::string> names;
};

// Begins anew when something else is to be looked at; what is under way then is not waited for.
void follow(const Context& context, Memory& memory, const engine::Piece& piece, const PrintProcess& process,
            const std::optional<engine::DraftLimit>& draft) {
  PrintPage& page = memory.print;
  const engine::Document& document = *context.now.document;
  auto around = aroundOf(document);
  if (page.seen != piece.version) {
    page.seen = piece.version;
    page.seenAtS = context.timeS;
  }
  if (page.version == piece.version && alike(page.pose, piece.pose) && alike(page.process, process) &&
      page.draft == draft && alike(page.around, around))
    return;
  if (context.timeS - page.seenAtS < kRestS) return;
  if (page.job) {
    page.job->job().cancel();
    memory.ending.push_back(std::move(page.job));
  }
  page.version = piece.version;
  page.pose = piece.pose;
  page.process = process;
  page.draft = draft;
  page.around = std::move(around);
  page.result = std::make_shared<PrintPage::Result>();
  page.job = std::make_unique<engine::BackgroundJob>([result = page.result, version = piece.version, pose = piece.pose,
                                                      process, draft, all = Around(document)](Job& job) {
    try {
      if (all.pieces.size() > 1) result->meets = all.meets(process.gapMm, job);
      result->report = engine::checkPrint(version, pose, process, &job);
      if (draft) result->pull = pulled(version, pose, *draft, job);
      result->bestPull = draft && draft->pull.isZero(0);
    } catch (const Cancelled&) {
      throw;
    } catch (const std::exception& error) {
      result->problem = error.what();
    }
  });
}

// A line of a list, which takes the camera there.
void place(Context& context, const Vec3d& atMm, const std::string& words) {
  ImGui::PushID(int(ImGui::GetCursorPosY()));
  if (kit::button(words, kit::Weight::plain, -1)) {
    render::Box box;
    box.min = atMm - Vec3d::Constant(kLookMm);
    box.max = atMm + Vec3d::Constant(kLookMm);
    context.camera.focus(box, double(context.width) / double(context.height));
  }
  kit::tooltip("Look at it.");
  ImGui::PopID();
}

void thin(Context& context, std::string_view name, const clay::ThinParts& found) {
  if (found.parts.empty()) return kit::fact(name, "none");
  kit::fact(name, fmt::format("{} · {:.2g} % of the surface", found.parts.size(), 100 * found.share()),
            colours().warning);
  for (size_t i = 0; i < std::min(kMostPlaces, found.parts.size()); ++i) {
    const clay::ThinPart& part = found.parts[i];
    place(context, part.atMm, kit::written(part.leastMm) + " mm, " + kit::written(part.areaMm2) + " mm²");
  }
}

void list(Context& context, const PrintProcess& process, const PrintReport& report) {
  const Colours& c = colours();
  thin(context, "Thin walls", report.walls);
  thin(context, "Narrow gaps", report.gaps);
  if (process.needsSupport) {
    kit::fact("Overhangs", report.overhangMm2 > 0 ? kit::written(report.overhangMm2) + " mm²" : "none",
              report.overhangs ? c.warning : 0);
    const auto& islands = report.slices.islands;
    kit::fact("Islands", islands.empty() ? "none" : std::to_string(islands.size()), islands.empty() ? 0 : c.warning);
    for (size_t i = 0; i < std::min(kMostPlaces, islands.size()); ++i)
      place(context, islands[i].at,
            islands[i].aloneMm > 0 ? "alone for " + kit::written(islands[i].aloneMm) + " mm" : "a body of its own");
  }
  size_t counted = 0;
  for (const clay::Trap& trap : report.slices.traps) counted += trap.closed || process.holdsLiquid;
  kit::fact("Hollows that stay full", counted == 0 ? "none" : std::to_string(counted), counted == 0 ? 0 : c.warning);
  size_t listed = 0;
  for (const clay::Trap& trap : report.slices.traps)
    if ((trap.closed || process.holdsLiquid) && ++listed <= kMostPlaces)
      place(context, trap.at, kit::written(trap.volumeMm3) + " mm³, " + (trap.closed ? "closed" : "open above"));
  if (process.outletMm > 0) {
    kit::fact("Narrow ways out", report.necks.empty() ? "none" : std::to_string(report.necks.size()),
              report.necks.empty() ? 0 : c.warning);
    for (size_t i = 0; i < std::min(kMostPlaces, report.necks.size()); ++i)
      place(context, report.necks[i].atMm, kit::written(2 * report.necks[i].radiusMm) + " mm wide");
  }
  const Vec3d size = report.highMm - report.lowMm, &bed = process.bedMm;
  kit::fact("Bed", report.fits ? "it fits" : "it does not fit", report.fits ? 0 : c.warning);
  kit::wrapped(fmt::format("{} × {} × {} mm on {} × {} × {}", kit::written(size.x()), kit::written(size.y()),
                           kit::written(size.z()), kit::written(bed.x()), kit::written(bed.y()), kit::written(bed.z())),
               c.dim);
}

void list(Context& context, const engine::PullReport& report) {
  const Colours& c = colours();
  const auto& undercuts = report.undercuts;
  kit::fact("Pulled along",
            fmt::format("{:.2f}, {:.2f}, {:.2f}", report.pull.x() + 0.0, report.pull.y() + 0.0, report.pull.z() + 0.0));
  kit::fact("Undercuts", undercuts.empty() ? "none" : std::to_string(undercuts.size()),
            undercuts.empty() ? 0 : c.warning);
  for (size_t i = 0; i < std::min(kMostPlaces, undercuts.size()); ++i)
    place(context, undercuts[i].atMm, kit::written(undercuts[i].areaMm2) + " mm²");
  kit::fact("Too little draft", report.steepMm2 > 0 ? kit::written(report.steepMm2) + " mm²" : "none",
            report.steepMm2 > 0 ? c.warning : 0);
}

void list(Context& context, const std::vector<std::pair<std::string, engine::PiecesMeet>>& meets) {
  kit::fact("Other pieces", meets.empty() ? "none meets it" : std::to_string(meets.size()),
            meets.empty() ? 0 : colours().warning);
  for (size_t i = 0; i < std::min(kMostPlaces, meets.size()); ++i) {
    const auto& [name, meet] = meets[i];
    place(context, meet.atMm,
          name + (meet.overlap   ? ": overlaps by " + kit::written(meet.mm) + " mm"
                  : meet.mm == 0 ? ": touches it"
                                 : ": " + kit::written(meet.mm) + " mm apart"));
  }
}

}  // namespace

void printPanel(Context& context, Memory& memory) {
  PrintChoice& choice = context.state.print;
  std::array<std::string_view, engine::kPrintProcesses> names;
  for (size_t i = 0; i < names.size(); ++i) names[i] = engine::printProcesses()[i].name;
  if (kit::choice("Printed in", names, choice.process, "Each way to print has its own limits.")) {
    choice.wallMm = engine::printProcesses()[size_t(choice.process)].wallMm;
    choice.gapMm = engine::printProcesses()[size_t(choice.process)].gapMm;
    choice.outletMm = engine::printProcesses()[size_t(choice.process)].outletMm;
    choice.bedMm = engine::printProcesses()[size_t(choice.process)].bedMm;
  }
  const PrintProcess& standard = engine::printProcesses()[size_t(choice.process)];
  kit::number({"wall", "Walls", "Thinner ones break or are not made.", "mm", 0.05, 20, standard.wallMm, true},
              choice.wallMm);
  kit::number({"gap", "Gaps", "Narrower ones are filled.", "mm", 0.05, 20, standard.gapMm, true}, choice.gapMm);
  kit::number({"outlet", "Ways out", "What is in a hollow does not leave it by narrower ones. 0: not looked for.", "mm",
               0, 20, standard.outletMm, false},
              choice.outletMm);
  constexpr double kMostBedMm = 100000;
  kit::number(
      {"bed width", "Bed width", "Width of the printer's bed, which is drawn on the ground; Nest uses the same.", "mm",
       1, kMostBedMm, standard.bedMm.x(), true},
      choice.bedMm.x());
  kit::number({"bed depth", "Bed depth", "Depth of the bed.", "mm", 1, kMostBedMm, standard.bedMm.y(), true},
              choice.bedMm.y());
  kit::number({"bed height", "Bed height", "Height to which it prints.", "mm", 1, kMostBedMm, standard.bedMm.z(), true},
              choice.bedMm.z());
  kit::toggle("Show on the clay", choice.shown,
              "Thin walls red to yellow, narrow gaps violet to blue, as the clay is worked on.");
  constexpr std::array<std::string_view, 5> kPulls{"not cast", "along X", "along Y", "along Z", "along the best pull"};
  kit::choice("From a mould", kPulls, choice.pull,
              "Two halves come off along this direction; the best is the one that Mould finds. Undercuts are magenta, "
              "faces with too little draft green.");
  if (choice.pull != 0)
    kit::number({"draft", "Draft", "Faces nearer to the axis than this stick.", "°", 0.1, 45, 2, true},
                choice.draftDegrees);

  kit::heading("In its way");
  PrintPage& page = memory.print;
  const engine::Document& document = *context.now.document;
  const auto piece = std::find_if(document.pieces.begin(), document.pieces.end(),
                                  [&](const engine::Piece& each) { return each.id == document.active; });
  if (piece == document.pieces.end() || !piece->version || piece->version.stats().bricks == 0)
    return kit::wrapped("There is no clay to look at.", colours().dim);
  const PrintProcess process = processOf(choice);
  follow(context, memory, *piece, process, draftOf(choice));
  if (page.job && page.job->done()) {
    page.shown = page.result;
    page.shownOf = page.process;
    page.job.reset();
  }
  if (page.job || page.version != piece->version) kit::dimText("Looking…");
  if (!page.shown) return;
  if (!page.shown->problem.empty()) return kit::wrapped(kit::sentence(page.shown->problem), colours().warning);
  if (page.shown->report) list(context, page.shownOf, *page.shown->report);
  if (page.shown->meets) list(context, *page.shown->meets);
  if (page.shown->pull) list(context, *page.shown->pull);
}

void followPrint(Context& context, Memory& memory) {
  PrintPage& page = memory.print;
  if (isSeen(memory.layout, context.state, *findPanel("print"))) {
    memory.moves = memory.moves || page.job || context.timeS - page.seenAtS < 2 * kRestS;  // there is something to come
  } else if (page.seen) {
    // Nobody looks, and clay that is worked on no more is not kept for this.
    if (page.job) {
      page.job->job().cancel();
      memory.ending.push_back(std::move(page.job));
    }
    page.seen = page.version = {};
    page.result = page.shown = nullptr;
  }
  context.state.bedShown = isSeen(memory.layout, context.state, *findPanel("print")) ||
                           (memory.operation.row && memory.operation.row->id == "nest");
  const PrintChoice& choice = context.state.print;
  std::optional<engine::CheckLimits> limits;
  if (choice.shown) limits = engine::CheckLimits{choice.wallMm, choice.gapMm};
  if (choice.pull != 0) {
    if (!limits) limits.emplace();
    limits->draft = draftOf(choice);
    // Until the best pull is found, and while the panel is away, the last one that was found is shown.
    if (limits->draft->pull.isZero(0)) {
      if (page.shown && page.shown->pull && page.shown->bestPull) page.bestPull = page.shown->pull->pull;
      if (page.bestPull)
        limits->draft->pull = *page.bestPull;
      else
        limits->draft.reset();
      if (!limits->draft && !choice.shown) limits.reset();
    }
  }
  if (limits == memory.print.told || ImGui::IsMouseDown(ImGuiMouseButton_Left)) return;  // a drag goes on
  context.bench.showChecks(memory.print.told = limits);
}

}  // namespace argil::studio
