#include "engine/tools/piece_jobs.h"

#include <algorithm>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "engine/tools/added_jobs.h"
#include "engine/tools/piece_cost.h"

namespace argil::engine {

std::span<const PieceJob> pieceJobs() {
  return addedJobs().all();
}

const PieceJob* findPieceJob(std::string_view id) {
  const auto rows = pieceJobs();
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const PieceJob& each) { return each.id == id; });
  return row == rows.end() ? nullptr : &*row;
}

PieceArguments standardArguments(const PieceJob& row, const Document& document) {
  PieceArguments arguments;
  for (const auto& parameter : row.parameters) parameter.change(arguments, parameter.standard);
  if (row.pieces > 0 && document.active != 0) arguments.pieces.push_back(document.active);
  return arguments;
}

PieceResult runPieceJob(const PieceJob& row, const Document& document, const PieceArguments& arguments, Job* job) {
  if (arguments.pieces.size() != static_cast<size_t>(row.pieces))
    throw Error(fmt::format("{} works on {}, {} given: choose {}", row.name,
                            row.pieces == 1 ? "one piece" : fmt::format("{} pieces", row.pieces),
                            arguments.pieces.size(), row.pieces == 2 ? "two pieces of clay" : "a piece of clay"));
  for (const Id id : arguments.pieces) {
    const Piece* piece = document.piece(id);
    if (!piece) throw Error(fmt::format("{}: there is no piece {}; choose one that is in the document", row.name, id));
    if (piece->locked) throw Error(fmt::format("{}: {} is locked; unlock it first", row.name, piece->name));
  }
  if (row.pieces == 2 && arguments.pieces[0] == arguments.pieces[1])
    throw Error(fmt::format("{}: choose two different pieces", row.name));
  for (const auto& parameter : row.parameters) {
    const double value = parameter.get(arguments);
    if (!(value >= parameter.low && value <= parameter.high))
      throw Error(fmt::format("{}: {} of {:g} {}: give {:g} to {:g}", row.name, parameter.name, value, parameter.unit,
                              parameter.low, parameter.high));
  }
  // Which machine it is does not matter to memory.
  requireMemoryFor(row, document, arguments, costOf(row, document, arguments, MachineSpeed()));
  return row.added ? runAdded(*row.added, document, arguments, job) : row.run(document, arguments, job);
}

void applyPieceResult(const PieceResult& result, const Document& before, Document& document) {
  const auto requireSame = [&](Id id) {
    const Piece *was = before.piece(id), *is = document.piece(id);
    if (!was || !is || was->version != is->version)
      throw Error(fmt::format("{} changed while that went on, so its result was left out: do it again",
                              was ? was->name : "the piece"));
  };
  for (const Piece& piece : result.changed) requireSame(piece.id);
  for (const Id id : result.removed) requireSame(id);
  for (const Piece& piece : result.changed) {
    Piece& target = *document.piece(piece.id);
    target.version = piece.version;
    target.pose = piece.pose;
    // What was hidden or renamed meanwhile stays so.
    if (piece.hideMasked != before.piece(piece.id)->hideMasked) target.hideMasked = piece.hideMasked;
    if (piece.materials != before.piece(piece.id)->materials) target.materials = piece.materials;
  }
  for (const Id id : result.removed) document.remove(id);
  for (Piece piece : result.added) {
    piece.id = 0;
    const auto taken = [&](const std::string& name) {
      return std::any_of(document.pieces.begin(), document.pieces.end(),
                         [&](const Piece& other) { return other.name == name; });
    };
    const std::string name = piece.name;
    for (int number = 2; !name.empty() && taken(piece.name); ++number) piece.name = fmt::format("{} {}", name, number);
    document.add(std::move(piece));
  }
}

}  // namespace argil::engine
