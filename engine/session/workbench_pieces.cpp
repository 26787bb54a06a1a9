// Operations on whole pieces, beside the person.

#include <fmt/format.h>

#include "clay/base/error.h"
#include "engine/session/workbench_state.h"
#include "engine/tools/piece_jobs.h"

namespace argil::engine {

void Workbench::operate(const std::string& id, PieceArguments arguments) {
  const PieceJob* row = findPieceJob(id);
  if (!row) {
    tell(Message::Level::error, fmt::format("There is no operation {}: choose one of the menus.", id));
    return;
  }
  const DocumentPtr before = snapshot()->document;
  const Piece* piece = arguments.pieces.empty() ? nullptr : before->piece(arguments.pieces.front());
  const std::string name = piece ? fmt::format("{} {}", row->doing, piece->name) : std::string(row->doing);
  state_->begin(name, [=, s = state_.get(), arguments = std::move(arguments)](Job& job) -> std::function<void()> {
    auto result = std::make_shared<const PieceResult>(runPieceJob(*row, *before, arguments, &job));
    State::Ready ready = s->prepare(result->changed, before.get());
    for (std::shared_ptr<Surfaces::Prepared>& each : s->prepare(result->added)) ready.push_back(std::move(each));
    return [=, ready = std::move(ready)] {
      Id made = 0;
      if (!result->changed.empty() || !result->added.empty() || !result->removed.empty())
        s->session->change(std::string(row->name), [&](Document& document) {
          if (row->pieces > 0) return applyPieceResult(*result, *before, document);
          // New pieces stand beside what is there and are worked on next.
          PieceResult placed = *result;
          const Vec3d move = State::besideAll(document, placed.added, {});
          for (Piece& each : placed.added) each.pose.translation += move;
          applyPieceResult(placed, *before, document);
          made = document.active = document.pieces.back().id;
        });
      if (made != 0) s->noteMade(made);
      for (const std::string& note : result->notes) s->tell(Message::Level::done, note);
    };
  });
}

}  // namespace argil::engine
