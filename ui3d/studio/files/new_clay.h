#pragma once
// Clay that is about to be made.

#include "engine/session/workbench.h"

namespace argil::studio {

/// Begins as a hand's size, fine enough to show a tool of 2 mm.
struct NewClay {
  int shape = 0;  ///< 0 block, 1 ball.
  double xMm = 60, yMm = 60, zMm = 40, roundMm = 4, radiusMm = 30, voxelMm = 0.5;
  bool halfMemory = false;
  double scale = 1;  ///< Of what it began as: a number of the series 1, 2, 5, 10.

  /// As large as what is in the document, the lengths that were chosen scaled along; as it is in an empty one.
  void fit(const engine::Document& document);
  /// Beside what is there.
  void add(engine::Workbench& bench) const;
};

}  // namespace argil::studio
