#include "engine/models/cad_export.h"

#include <fmt/format.h>

#include <deque>

#include "clay/base/error.h"
#include "clay/cage/fit_cage.h"
#include "clay/field/region_work.h"
#include "io/cad/step_file.h"

namespace argil::engine {

std::vector<std::string> writeCad(const std::filesystem::path& file, const Document& document, const ModelExport& what,
                                  Job* job) {
  std::vector<const Piece*> pieces;
  for (const Piece& each : document.pieces)
    if (each.version && (what.piece != 0 ? each.id == what.piece : !what.visibleOnly || each.visible))
      pieces.push_back(&each);
  if (pieces.empty()) throw Error("there is no clay to export: show a piece, or export the hidden ones too");
  io::AtomicFile out(file);  // What is wrong with a name is told before the work.
  const clay::WorkPart all(job);
  std::deque<clay::FittedPatches> fitted;
  std::vector<io::StepBody> bodies;
  std::vector<std::string> sentences;
  for (size_t i = 0; i < pieces.size(); ++i) {
    const Piece& piece = *pieces[i];
    const double from = 0.9 * double(i) / double(pieces.size()), to = 0.9 * double(i + 1) / double(pieces.size());
    fitted.push_back(clay::fitPatches(piece.version, what.cadQuads, clay::threadCount(0), all.part(from, to)));
    const clay::FittedPatches& made = fitted.back();
    io::StepBody body{piece.name, &made.surface};
    body.pose.linear() = piece.pose.rotation.toRotationMatrix();
    body.pose.translation() = piece.pose.translation + (what.putBack ? piece.fileOffsetMm : Vec3d::Zero());
    body.colour = piece.colour;
    bodies.push_back(body);
    const clay::OneWay &there = made.deviation.fromPatches, &back = made.deviation.fromClay;
    sentences.push_back(fmt::format(
        "{}: {} smooth faces; from them to the clay {:.2g} mm RMS, {:.2g} in 99 of 100 places, {:.2g} at most (bound "
        "{:.2g}); from the clay to them {:.2g}, {:.2g}, {:.2g}; {} corners where other than four meet.",
        piece.name, made.surface.patches.size(), there.rms, there.p99, there.max, made.deviation.boundMm, back.rms,
        back.p99, back.max, made.irregular));
  }
  io::writeStep(out, file.stem().string(), bodies, job);
  const double megabytes = double(out.bytes()) * 1e-6;
  out.commit();
  sentences.push_back(fmt::format("{}: {} solid{} written as STEP, {:.1f} MB.", file.filename().string(), bodies.size(),
                                  bodies.size() == 1 ? "" : "s", megabytes));
  return sentences;
}

}  // namespace argil::engine
