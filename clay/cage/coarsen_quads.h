#pragma once
// A cage of few quads from a mesh of many, small where a size says so.

#include <memory>

#include "clay/base/work_part.h"
#include "clay/cage/quad_mesh.h"
#include "clay/cage/web_on_surface.h"

namespace argil::clay {

struct Coarsening {
  /// Quads may come farther off the surface where that leaves fewer vertices of other than four.
  bool regular = false;
  /// A step on the way to fewer: quads that are alone on a side of a crease stay so.
  bool between = false;
};

/// At most `most` quads of the same closed shape, bodies, handles and all, whose edges are as long as the sizes of the
/// ground say in proportion. Middles of edges and quads lie no farther off the surface than a fifth of their length, or
/// of twice the size there, or the finest, and than a third of a wall, where so few quads allow it: a limb has four
/// around it, a plate has both its sides. Where so few are not possible at all the result has more. Creases of `fine`
/// stay creases: their vertices slide along those of the surface, and their corners stay. Throws Error for a mesh that
/// is not closed, Cancelled. Cost: about 0.2 ms a quad that goes.
[[nodiscard]] QuadMesh coarsened(QuadMesh fine, const WebGround& ground, size_t most, const WorkPart& part,
                                 Coarsening how = {});

/// coarsened() for several counts of quads: what all of them begin with is done once.
class SharedCoarsening {
 public:
  /// For at most `most` quads, or less. The ground must outlive it. Throws as coarsened().
  SharedCoarsening(QuadMesh fine, const WebGround& ground, size_t most, const WorkPart& part);
  ~SharedCoarsening();
  SharedCoarsening(const SharedCoarsening&) = delete;
  SharedCoarsening& operator=(const SharedCoarsening&) = delete;
  [[nodiscard]] size_t most() const;
  /// To the bit what coarsened() gives. `most`: no more than most(). Any threads.
  [[nodiscard]] QuadMesh to(size_t most, const WorkPart& part, Coarsening how = {}) const;

 private:
  struct State;
  std::unique_ptr<State> state_;
};

/// The same quads, their vertices on the surface and edges as even as coarsened() makes them; no quad is joined
/// and no edge turned. Throws as coarsened(). Cost: about 0.2 ms a quad.
[[nodiscard]] QuadMesh evenedOut(QuadMesh mesh, const WebGround& ground, const WorkPart& part);

}  // namespace argil::clay
