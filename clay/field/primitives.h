#pragma once
// Clay from shapes. Distances are exact. Each side 2 to 65 536 voxels, and 1e6 mm from zero at most; throws Error
// otherwise, Cancelled. Cost follows the surface.

#include <memory>

#include "clay/base/job.h"
#include "clay/store/version.h"

namespace argil::clay {

/// A ball.
[[nodiscard]] Version makeSphere(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm, double radiusMm,
                                 Job* job = nullptr);

/// An axis-aligned block with rounded edges and corners (`roundMm` may be 0).
[[nodiscard]] Version makeBlock(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm,
                                const Vec3d& sizeMm, double roundMm, Job* job = nullptr);

/// A cylinder about the z axis with rounded rims (`roundMm` may be 0).
[[nodiscard]] Version makeCylinder(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm,
                                   double radiusMm, double heightMm, double roundMm = 0, Job* job = nullptr);

/// A cone about the z axis, `topRadiusMm` above (0: a tip). `centreMm` is half way up.
[[nodiscard]] Version makeCone(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm,
                               double baseRadiusMm, double topRadiusMm, double heightMm, Job* job = nullptr);

/// A cylinder from one point to another, both ends with a chamfer of 45° (may be 0).
[[nodiscard]] Version makeRod(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& fromMm, const Vec3d& toMm,
                              double radiusMm, double chamferMm = 0, Job* job = nullptr);

/// A ring about the z axis: a tube of radius `tubeMm` along a circle of radius `ringMm`, which is not smaller.
[[nodiscard]] Version makeTorus(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm, double ringMm,
                                double tubeMm, Job* job = nullptr);

/// An axis-aligned ellipsoid; distances are to its nearest point, to 1e-6 voxel.
[[nodiscard]] Version makeEllipsoid(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm,
                                    const Vec3d& radiiMm, Job* job = nullptr);

}  // namespace argil::clay
