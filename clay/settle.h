#pragma once
// Redistancing after an operation on a whole piece.

#include <span>

#include "clay/editor.h"
#include "clay/job.h"

namespace argil::clay {

/// As redistance(), for any number of bricks (sorted, each once), region by region, so that memory does not grow with them. Reports the job's fraction from `jobFrom`
/// to 1. One thread; 4 µs a brick.
void redistanceByRegion(Editor& editor, std::span<const Coord> bricks, Job* job = nullptr, double jobFrom = 0);

}  // namespace argil::clay
