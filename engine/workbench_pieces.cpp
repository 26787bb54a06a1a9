// Operations on whole pieces, beside the person.

#include <fmt/format.h>

#include "clay/error.h"
#include "engine/piece_jobs.h"
#include "engine/workbench_state.h"

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
      if (!result->changed.empty() || !result->added.empty() || !result->removed.empty())
        s->session->change(std::string(row->name), [&](Document& document) { applyPieceResult(*result, *before, document); });
      for (const std::string& note : result->notes) s->tell(Message::Level::done, note);
    };
  });
}

}  // namespace argil::engine
