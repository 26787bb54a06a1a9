#pragma once
// Clay from shapes.

#include <memory>

#include "clay/job.h"
#include "clay/version.h"

namespace argil::clay {

/// A ball. Radius 1 to 30 000 voxels; throws Error otherwise, Cancelled. Cost follows the surface.
[[nodiscard]] Version makeSphere(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm, double radiusMm,
                                 Job* job = nullptr);

/// An axis-aligned block with rounded edges and corners (`roundMm` may be 0).
[[nodiscard]] Version makeBlock(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm, const Vec3d& sizeMm,
                                double roundMm, Job* job = nullptr);

}  // namespace argil::clay
