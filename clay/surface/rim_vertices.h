#pragma once
// Vertices on the rims of cuts and of laid-on clay, also where the wedge between two faces is thinner than a voxel.

#include <array>
#include <bitset>

#include "clay/store/sampler.h"
#include "clay/surface/brick_extraction.h"

namespace argil::clay {

/// How far a vertex of any grade may stand outside of its cell, voxels: the tip of a wedge of 16° does by so much.
inline constexpr float kVertexReach = 3.5f;

/// A vertex that may stand at a rim.
struct RimSuspect {
  uint16_t vertex;  ///< Its index in the brick.
  uint16_t cell;    ///< x·64 + y·8 + z.
  uint16_t edges;   ///< Crossed edges of its loop, as clay/kernels/cell_cases.h numbers them.
  bool kinked;      ///< Its cell or one beside it is kinked; else it moves only if it stands on a rim.
};

using PlacedVertices = std::bitset<ExtractionBuffer::kMostVertices>;

/// Bit by cell of a brick, x·64 + y·8 + z.
using RimCells = std::bitset<kBrickVoxels>;

/// Moves those of `suspects` that share a group with one of the cells `hard`, or `all`, to the rim or the face where
/// they belong for which faces are found that explain the field around; sets their bits in `placed`, and in `sharp`
/// those of vertices on rims and corners. Equal bits everywhere. Method: rims.md.
void placeOnRims(Sampler& field, Coord brick, std::span<const RimSuspect> suspects, const RimCells& hard, bool all,
                 bool wantNormals, ExtractionBuffer& out, PlacedVertices& placed, PlacedVertices& sharp);

}  // namespace argil::clay
