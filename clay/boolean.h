#pragma once
// Two clays become one.

#include <cstdint>
#include <vector>

#include "clay/editor.h"
#include "clay/job.h"
#include "clay/redistance.h"
#include "clay/work_part.h"

namespace argil::clay {

enum class Combination : uint8_t {
  join,       ///< What is in either.
  cut,        ///< What is in the first and not in the second.
  intersect,  ///< What is in both.
};

struct CombineOptions {
  /// Width over which the two surfaces run into each other, 0 to 100 voxels; 0: they meet in a sharp crease.
  double blendMm = 0;
  int threads = 0;  ///< 0 for all cores; of resampling and blending. The result does not depend on it.
  /// What b's materials become, by their number; those beyond its end, as with none, stay.
  std::vector<uint8_t> materials = {};
};

/// A version made from `a`, in its store, beside whoever edits there: whole nodes of it are shared wherever `b` is all
/// inside or all outside, and where `a` is so, b's bricks are copied. A `b` on another grid is resampled first: see
/// resample(). Where both surfaces meet distances are made anew. Channels come with the surface that is nearer, those
/// of a cut with b's. Throws Error for a blend out of range, Cancelled. The result may be empty. Cost follows the
/// bricks of b and those of a near b.
[[nodiscard]] Version combine(const Version& a, const Version& b, Combination how, const CombineOptions& options = {},
                              Job* job = nullptr);

/// The same as part of some work.
[[nodiscard]] Version combine(const Version& a, const Version& b, Combination how, const CombineOptions& options,
                              const WorkPart& part);

/// Bricks of `coords` without a sign change in themselves or a neighbour become tiles: a band is no wider than a brick.
void dropWithoutSurface(Editor& editor, const std::vector<Coord>& coords);
/// redistance() of any number of bricks, after those without a surface near became tiles, in an order of their own:
/// about 10 KB each at a time, twice where there are too many for one call.
void redistanceAll(Editor& editor, std::vector<Coord> coords, const WorkPart& part,
                   float tolerance = kRedistanceTolerance);
/// Those of the bricks around `coords` (themselves among them) that the editor has, each once, sorted.
[[nodiscard]] std::vector<Coord> bricksAround(const Editor& editor, const std::vector<Coord>& coords);

}  // namespace argil::clay
