#pragma once
// Two clays become one.

#include <cstdint>
#include <vector>

#include "clay/base/job.h"
#include "clay/base/work_part.h"
#include "clay/field/redistance.h"
#include "clay/store/editor.h"

namespace argil::clay {

struct ThinParts;  // clay/field/thin_parts.h

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
  ThinParts* gone = nullptr;  ///< What went because it was too thin is added to it, where there is no blend.
};

/// A version made from `a`, in its store, beside whoever edits there: whole nodes of it are shared wherever `b` is all
/// inside or all outside, and where `a` is so, b's bricks are copied. A `b` on another grid is resampled first: see
/// resample(). Where both surfaces meet distances are made anew. What is thinner than kThinnest goes: films where faces
/// of both coincide, and gaps between faces that touch, which become one body. Channels come with the surface that is
/// nearer, those of a cut with b's. Throws Error for a blend out of range, Cancelled. The result may be empty. Cost
/// follows the bricks of b and those of a near b.
[[nodiscard]] Version combine(const Version& a, const Version& b, Combination how, const CombineOptions& options = {},
                              Job* job = nullptr);

/// The same as part of some work.
[[nodiscard]] Version combine(const Version& a, const Version& b, Combination how, const CombineOptions& options,
                              const WorkPart& part);

}  // namespace argil::clay
