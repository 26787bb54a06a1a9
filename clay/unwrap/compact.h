#pragma once
// Shapes that were placed in a square, pushed nearer together.

#include "clay/unwrap/pack.h"

namespace argil::clay {

/// Makes the square smaller, step by step: shapes that come too near to each other or to the rim are pushed apart and
/// turned; one goes elsewhere where that does not suffice (separation, as in nesting: Bennell and Oliveira 2008). Of
/// several beginnings the best is followed. In the result no outline is nearer to another than `margin` of the square's
/// side, nor to its rim than half of that; the square is never larger than the smallest of `starts` (at least one, each
/// of all shapes). Throws Cancelled, after one try of a side at most. Cost: one to three seconds for 15 shapes and
/// eight starts on two threads. The same on any number of threads.
[[nodiscard]] Packing compacted(const std::vector<FlatShape>& shapes, std::vector<Packing> starts, double margin,
                                int threads, const WorkPart& part);

}  // namespace argil::clay
