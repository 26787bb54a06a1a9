#pragma once
// Distances to tips other than the ball, swept along a stamp's way. This module's own.

#include <span>

#include "clay/brush/brush.h"

namespace argil::clay {

/// Distances (negative inside) of the voxels of a brick to the tip of `brush` swept along `stamp`. Ellipsoid and box:
/// of the swept solid, without scallops, right within 2 % a voxel from its surface; a shape: the least over places a
/// voxel apart. Equal bits on every CPU, mirrored ones for mirrored stamps.
void tipDistances(const Brush& brush, const Stamp& stamp, Coord coord, float (&distance)[kBrickVoxels]);

/// Radii, of the stamp's, of the balls around and within a tip: what is farther from the way is untouched, what is
/// nearer is covered whole.
double aroundTip(const Brush& brush);
double withinTip(const Brush& brush);

}  // namespace argil::clay
