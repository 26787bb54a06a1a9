#pragma once
// Distances of a brick to 16-bit codes and back. This module's own.

#include "clay/kernels/brick.h"

namespace argil::clay {

/// The nearest codes, ties to even, so that a distance and its negative have opposite ones; below zero stays below zero
/// (−1 at least), so the surface never crosses a voxel. `values` as Brick::phi says, `band` that of the version. False
/// when all became ±kMostCode: no brick. Equal bits on every CPU.
bool packDistances(const BrickValues& values, float band, int16_t (&codes)[kBrickVoxels]) noexcept;

}  // namespace argil::clay
