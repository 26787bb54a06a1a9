// Where the pegs of a cut would stand, while it is asked about: found beside the studio whenever something changed.

#include <exception>

#include "clay/base/error.h"
#include "engine/tools/piece_values.h"
#include "ui3d/studio/kit/theme.h"
#include "ui3d/studio/panels/memory.h"

namespace argil::studio {
namespace {

void begin(PegPreview& preview, const engine::Piece& piece, const engine::PieceArguments& arguments) {
  preview.of = piece.version;
  preview.arguments = arguments;
  preview.result = std::make_shared<PegPreview::Result>();
  preview.job = std::make_unique<engine::BackgroundJob>(
      [result = preview.result, version = piece.version, pose = piece.pose, arguments](Job& job) {
        try {
          const auto& values = arguments.get<engine::PegValues>();
          clay::PegPlan plan = clay::planPegs(version,
                                              {.pointMm = pose.applyInverse(arguments.plane.pointMm),
                                               .normal = pose.rotation.conjugate() * arguments.plane.normal,
                                               .pegs = values.pegs,
                                               .diameterMm = values.diameterMm,
                                               .depthMm = values.depthMm,
                                               .clearanceMm = values.clearanceMm,
                                               .loose = values.loose},
                                              clay::WorkPart(&job));
          for (clay::Peg& peg : plan.pegs) peg.atMm = pose.apply(peg.atMm);
          result->plan = std::move(plan);
        } catch (const Cancelled&) {
          throw;
        } catch (const std::exception& error) {
          result->problem = error.what();
        }
      });
}

void drop(Memory& memory) {
  PegPreview& preview = memory.pegs;
  if (preview.job) {
    preview.job->job().cancel();
    memory.ending.push_back(std::move(preview.job));
  }
  preview = {};
}

}  // namespace

std::string followPegs(Context& context, Memory& memory, const engine::Piece* piece) {
  const Operation& operation = memory.operation;
  context.state.pegs.reset();
  if (!operation.row || operation.row->id != "cut-pegs" || !piece || !piece->version) {
    if (memory.pegs.of) drop(memory);
    return {};
  }
  PegPreview& preview = memory.pegs;
  if (preview.of != piece->version || !(preview.arguments == operation.arguments)) {
    if (preview.job) {
      preview.job->job().cancel();
      memory.ending.push_back(std::move(preview.job));
    }
    begin(preview, *piece, operation.arguments);
  }
  memory.moves = true;
  if (preview.job && !preview.job->done()) {
    kit::dimText("Looking for places for pegs…");
    return {};
  }
  preview.job.reset();
  if (!preview.result->problem.empty()) return preview.result->problem;
  const clay::PegPlan& plan = preview.result->plan;
  const bool loose = operation.arguments.get<engine::PegValues>().loose;
  context.state.pegs = PegsShown{plan.pegs, operation.arguments.plane.normal.normalized(), loose};
  kit::fact("Pegs that find room", std::to_string(plan.pegs.size()));
  if (plan.without > 0)
    kit::fact("Areas without a peg", std::to_string(plan.without) + " of " + std::to_string(plan.areas),
              colours().warning);
  return {};
}

}  // namespace argil::studio
