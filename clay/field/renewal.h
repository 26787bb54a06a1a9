#pragma once
// Distances of second order from a field that is none. This module's own.

#include <span>
#include <vector>

#include "clay/field/redistance.h"
#include "clay/store/editor.h"

namespace argil::clay {

/// What redistance() does where a `renew` is Renew::all: beside the surface the distance to the surface of the tricubic
/// field, found by following it to its foot; from there |∇u| = 1 upwind and of second order, so that what a stroke
/// leaves does not know the grid's axes. `coords` and `renew`: as redistance(); `wanted` and the result: as
/// solveDistances(). Method: NOTES.md, "Redistancing".
std::vector<SettledBrick> renewDistances(Editor& editor, std::span<const Coord> coords, std::span<const Renew> renew,
                                         std::span<const uint8_t> wanted, int threads);

}  // namespace argil::clay
