#pragma once
// Vertices of the surface at creases, quickly: the live grade's step after the draft's.

#include <cstdint>
#include <span>

#include "clay/store/sampler.h"
#include "clay/surface/brick_extraction.h"

namespace argil::clay {

/// Cells of a brick in the order of their vertices, with their corner patterns; those of them that a crease may cross,
/// in order.
struct KinkedCells {
  const uint16_t* cells;
  const uint32_t* patterns;
  std::span<const uint16_t> kinked;
};

/// Moves the vertices of kinked cells onto the crease between the two faces that meet there, or onto the face that the
/// cell is on, and lists the former in out.table.sharp. Changes no count, no order and no quad; none ends farther than
/// kCrispReach outside of its cell. Cells with several vertices stay as they are. Scalar arithmetic in a fixed order:
/// equal bits everywhere. About three microseconds a cell. Method: crisp_edges.md.
void crispVertices(Sampler& field, Coord brick, const KinkedCells& cells, bool wantNormals, ExtractionBuffer& out);

}  // namespace argil::clay
