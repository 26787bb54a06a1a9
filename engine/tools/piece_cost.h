#pragma once
// What an operation on whole pieces will take before it is begun.

#include "engine/document/machine_speed.h"
#include "engine/tools/piece_jobs.h"

namespace argil::engine {

/// About; within a quarter for what `argil bench costs` tries.
struct PieceCost {
  double coreSeconds = 0;  ///< Of one core: several share most of it.
  double bytes = 0;        ///< Of what is made beside what there is: clay, and the surface that shows it.
};

/// Of a row on pieces that exist, with arguments within their ranges. Any thread; O(bricks of the pieces) where it
/// needs their bounds.
[[nodiscard]] PieceCost costOf(const PieceJob& row, const Document& document, const PieceArguments& arguments,
                               const MachineSpeed& machine);

/// "about 3 s, 210 MB": of work that `cores` share; "less than 0.1 s" where it makes no clay.
[[nodiscard]] std::string sentence(const PieceCost& cost, int cores);

/// Throws Error where the memory that there is would not hold what is made.
void requireMemoryFor(const PieceJob& row, const Document& document, const PieceArguments& arguments,
                      const PieceCost& cost);

}  // namespace argil::engine
