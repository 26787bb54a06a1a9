#pragma once
// Vertices of the surface at creases, quickly: the live grade's step after the draft's.

#include <cstdint>

#include "clay/store/sampler.h"
#include "clay/surface/brick_extraction.h"
#include "clay/surface/rim_vertices.h"

namespace argil::clay {

/// Cells of a brick in the order of their vertices, with their corner patterns, and as words x·64 + y·8 + z those of
/// them that are kinked and bent (clay/kernels/surface_kernels.h).
struct CreaseCells {
  const uint16_t* cells;
  const uint32_t* patterns;
  int count;
  const float* corners;  ///< Distances at theirs (cornerOffset).
  uint64_t kinked[8], bent[8];
};

/// Moves the vertices of cells that a crease crosses onto it, or onto the face that the cell is on, and lists the
/// former in out.table.sharp. Looks at kinked cells, and at bent ones that share a face with a kinked one. Changes no
/// count, no order and no quad. Rims of acute wedges and corners are then fitted (placeOnRims); `placed` gets a bit for
/// each vertex that was. Sets out.table.readsBeyond where other bricks were read. For the fine grade only vertices that
/// come onto a crease between faces of which one turns are moved. Equal bits everywhere. About half a microsecond a
/// cell. Method: crisp_edges.md.
void crispVertices(Sampler& field, Coord brick, const CreaseCells& cells, bool wantNormals, Grade grade,
                   ExtractionBuffer& out, PlacedVertices& placed);

}  // namespace argil::clay
