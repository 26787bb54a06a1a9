#include "engine/models/cad_export.h"

#include <fmt/format.h>

#include <algorithm>
#include <deque>
#include <iterator>

#include "clay/base/error.h"
#include "clay/base/rounded_up.h"
#include "clay/cage/fit_cage.h"
#include "clay/field/region_work.h"
#include "engine/models/model_colours.h"
#include "engine/models/quad_wishes.h"
#include "io/cad/iges_file.h"
#include "io/cad/step_file.h"

namespace argil::engine {
namespace {

constexpr double kWorthTellingS = 10;  // Who waited no longer does not ask where the time went.

}  // namespace

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
  std::vector<io::CadBody> bodies;
  std::vector<std::string> sentences;
  for (size_t i = 0; i < pieces.size(); ++i) {
    const Piece& piece = *pieces[i];
    const double from = 0.9 * double(i) / double(pieces.size()), to = 0.9 * double(i + 1) / double(pieces.size());
    const int threads = clay::threadCount(0);
    std::vector<clay::PatchTry> tries;
    const clay::CageWishes wishes = wishesFor(document, piece, what);
    fitted.push_back(what.cadErrorMm
                         ? clay::fitPatchesWithin(piece.version, *what.cadErrorMm, what.cadQuads, threads,
                                                  all.part(from, to), tries, wishes)
                         : clay::fitPatches(piece.version, what.cadQuads, threads, all.part(from, to), wishes));
    const clay::FittedPatches& made = fitted.back();
    io::CadBody body{piece.name, &made.surface};
    body.pose.linear() = piece.pose.rotation.toRotationMatrix();
    body.pose.translation() = piece.pose.translation + (what.putBack ? piece.fileOffsetMm : Vec3d::Zero());
    body.colour = chosenColour(piece);
    bodies.push_back(body);
    const clay::OneWay &there = made.deviation.fromPatches, &back = made.deviation.fromClay;
    sentences.push_back(fmt::format(
        "{}: {} smooth faces; from them to the clay {:.2g} mm RMS, {:.2g} in 99 of 100 places, {:.2g} at most; from "
        "the "
        "clay to them {:.2g}, {:.2g}, {:.2g} (bound of both ways {:.2g}); {} corners where other than four meet.",
        piece.name, made.surface.patches.size(), there.rms, there.p99, clay::roundedUp(there.max), back.rms, back.p99,
        clay::roundedUp(back.max), clay::roundedUp(made.deviation.boundMm), made.irregular));
    const clay::FitTimes& spent = made.times;
    if (const double tookS = spent.cages + spent.fits + spent.measuring; tookS > kWorthTellingS)
      sentences.push_back(
          fmt::format("{}: took {:.0f} s: {:.0f} to draw quads around it, {:.0f} to fit smooth faces, "
                      "{:.0f} to measure how far they lie off.",
                      piece.name, tookS, spent.cages, spent.fits, spent.measuring));
    std::ranges::move(wishWords(document, piece, what, made.met), std::back_inserter(sentences));
    const auto placesOf = [&](const auto& places, const auto& told) {
      std::string text;
      for (const auto& each : places) text += (text.empty() ? "" : ", ") + told(each);
      return text;
    };
    const auto at = [&](const Vec3d& place) {
      const Vec3d mm = body.pose * place;
      return fmt::format("({:.1f}, {:.1f}, {:.1f})", mm.x(), mm.y(), mm.z());
    };
    if (!made.deviation.foldsMm.empty())
      sentences.push_back(
          fmt::format("{}: faces fold over themselves at {}: some CAD programs refuse such faces; ask for more of "
                      "them, or smooth the "
                      "clay there.",
                      piece.name, placesOf(made.deviation.foldsMm, at)));
    if (!what.cadErrorMm) continue;
    std::string sentence = fmt::format("{}: tried ", piece.name);
    for (const clay::PatchTry& one : tries)
      sentence += fmt::format("{}{} faces ({:.2g} mm, bound {:.2g})", &one == tries.data() ? "" : ", ", one.quads,
                              clay::roundedUp(one.mostMm), clay::roundedUp(one.boundMm));
    sentences.push_back(sentence + ".");
    if (std::max(made.deviation.mostMm(), made.deviation.boundMm) <= *what.cadErrorMm) continue;
    sentence = fmt::format("{}: {} faces do not keep within {:g} mm everywhere", piece.name,
                           made.surface.patches.size(), *what.cadErrorMm);
    const std::string far = placesOf(made.deviation.far, [&](const clay::PatchDeviation::Place& each) {
      return fmt::format("{:.2g} mm at {}", each.offMm, at(each.mm));
    });
    sentences.push_back(sentence + ": " + (far.empty() ? "the bound alone is beyond it" : far) + ".");
  }
  const bool iges = io::isIges(file);
  (iges ? io::writeIges : io::writeStep)(out, file.stem().string(), bodies, job);
  const double megabytes = double(out.bytes()) * 1e-6;
  out.commit();
  sentences.push_back(fmt::format("{}: {} solid{} written as {}, {:.1f} MB.", file.filename().string(), bodies.size(),
                                  bodies.size() == 1 ? "" : "s", iges ? "IGES" : "STEP", megabytes));
  return sentences;
}

}  // namespace argil::engine
