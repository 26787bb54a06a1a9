#pragma once
// Vertices of the surface at creases: the fine grade's step after the draft's.

#include <array>
#include <cstdint>
#include <span>

#include "clay/store/sampler.h"
#include "clay/surface/brick_extraction.h"
#include "clay/surface/rim_vertices.h"

namespace argil::clay {

/// How far a vertex of the fine surface may lie outside of its cell, in voxels along an axis: the tip of a right-angled
/// wedge between two rows of voxels stands out by up to half a voxel.
inline constexpr float kSharpReach = 1.0f;

/// Is the field in some of these cells bent enough for a crease? From the values alone that the draft has at hand;
/// `corners` and `cells` as for cellVertices. Well below a nanosecond a cell.
[[nodiscard]] bool mayHoldCrease(const float* corners, const uint16_t* cells, int count) noexcept;

/// Moves the vertices of `brick` (as extractVertices leaves them) that stand at a crease or a corner onto it, those
/// beside it onto their face, and lists the former in out.table.sharp. Changes no count, no order and no quad; none
/// ends farther than kSharpReach outside of its cell; those of bent cells without a crease go onto the bend. With
/// `wantNormals` a moved vertex gets the mean normal of its faces. Scalar arithmetic in a fixed order: equal bits
/// everywhere. 1 to 2 µs for each cell near a crease. Where flat faces do not explain a cell, a vertex that is listed
/// before (crispVertices) stays as it is, and so does any in `placed`. Method: sharp_features.md.
void sharpenVertices(Sampler& field, Coord brick, bool wantNormals, const PlacedVertices& placed,
                     ExtractionBuffer& out);

/// Turns quads, as extractQuads makes them, so that they are split along creases: between two opposite sharp vertices,
/// which the other diagonal would cut off; of three sharp ones through the middle one, or a triangle would lie along
/// the crease without area, unless that one stands out of the plane of the others: then it is on another face. Costs
/// nothing where no source has sharp vertices.
void splitAlongCreases(const std::array<VertexSource, 8>& sources, std::span<std::array<VertexRef, 4>> quads);

}  // namespace argil::clay
