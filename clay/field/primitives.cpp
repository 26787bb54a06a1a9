#include "clay/field/primitives.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/field/solid_from.h"

namespace argil::clay {

namespace {

using solid::make;

// Of a point (r, z) to the segment from (r0, z0) to (r1, z1).
double toSegment(double r, double z, double r0, double z0, double r1, double z1) {
  const double dr = r1 - r0, dz = z1 - z0, length2 = dr * dr + dz * dz;
  const double t = length2 > 0 ? std::clamp(((r - r0) * dr + (z - z0) * dz) / length2, 0.0, 1.0) : 0.0;
  const double x = r - r0 - t * dr, y = z - z0 - t * dz;
  return std::sqrt(x * x + y * y);
}

// Eberly, "Distance from a Point to an Ellipse, an Ellipsoid, or a Hyperellipsoid": the nearest point is e² y / (t +
// e²) for the greatest root t of a convex function, which Newton's method meets from the left without ever passing it.
double toEllipsoid(const Vec3d& p, const Vec3d& e) {
  constexpr double kOffAxis = 1e-6;  // Voxels: on a plane of symmetry the root may be the pole itself.
  const Vec3d y = p.cwiseAbs().cwiseMax(kOffAxis), e2 = e.cwiseProduct(e), ey = e.cwiseProduct(y);
  double t = (ey - e2).maxCoeff();
  for (int i = 0; i < 100; ++i) {
    double value = -1, slope = 0;
    for (int k = 0; k < 3; ++k) {
      const double d = t + e2[k], q = ey[k] / d, q2 = q * q;
      value += q2;
      slope -= 2 * q2 / d;
    }
    const double step = -value / slope;
    t += step;
    if (!(step > 1e-12 * e2.minCoeff())) break;
  }
  const double distance = std::sqrt((e2.cwiseProduct(y).cwiseQuotient(e2 + Vec3d::Constant(t)) - y).squaredNorm());
  return t < 0 ? -distance : distance;
}

}  // namespace

Version makeSphere(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm, double radiusMm, Job* job) {
  const Vec3d centre = grid.toVoxel(centreMm);
  const double radius = radiusMm / grid.voxelMm;
  return make(std::move(store), grid, centreMm, Vec3d::Constant(radiusMm), "sphere", job,
              [&](const Vec3d& p) { return (p - centre).norm() - radius; });
}

Version makeBlock(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm, const Vec3d& sizeMm,
                  double roundMm, Job* job) {
  if (!(roundMm >= 0 && 2 * roundMm <= sizeMm.minCoeff()))
    throw Error(fmt::format("block rounded by {} mm: give a radius from 0 to half its shortest side", roundMm));
  const Vec3d centre = grid.toVoxel(centreMm);
  const double round = roundMm / grid.voxelMm;
  const Vec3d core = sizeMm / (2 * grid.voxelMm) - Vec3d::Constant(round);
  return make(std::move(store), grid, centreMm, sizeMm / 2, "block", job, [&](const Vec3d& p) {
    const Vec3d q = (p - centre).cwiseAbs() - core;
    return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0) - round;
  });
}

Version makeCylinder(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm, double radiusMm,
                     double heightMm, double roundMm, Job* job) {
  if (!(roundMm >= 0 && roundMm <= radiusMm && 2 * roundMm <= heightMm))
    throw Error(
        fmt::format("cylinder rounded by {} mm: give a radius from 0 to its own and to half its height", roundMm));
  const Vec3d centre = grid.toVoxel(centreMm);
  const double round = roundMm / grid.voxelMm, radius = radiusMm / grid.voxelMm - round,
               half = heightMm / (2 * grid.voxelMm) - round;
  return make(std::move(store), grid, centreMm, {radiusMm, radiusMm, heightMm / 2}, "cylinder", job,
              [&](const Vec3d& p) {
                const Vec3d d = p - centre;
                const double r = std::sqrt(d.x() * d.x() + d.y() * d.y()) - radius, z = std::abs(d.z()) - half;
                const double outR = std::max(r, 0.0), outZ = std::max(z, 0.0);
                return std::sqrt(outR * outR + outZ * outZ) + std::min(std::max(r, z), 0.0) - round;
              });
}

Version makeCone(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm, double baseRadiusMm,
                 double topRadiusMm, double heightMm, Job* job) {
  if (!(baseRadiusMm >= 0 && topRadiusMm >= 0))
    throw Error(fmt::format("cone of radii {} and {} mm: neither may be negative", baseRadiusMm, topRadiusMm));
  const Vec3d centre = grid.toVoxel(centreMm);
  const double base = baseRadiusMm / grid.voxelMm, top = topRadiusMm / grid.voxelMm,
               half = heightMm / (2 * grid.voxelMm);
  const double widest = std::max(baseRadiusMm, topRadiusMm);
  return make(std::move(store), grid, centreMm, {widest, widest, heightMm / 2}, "cone", job, [&](const Vec3d& p) {
    const Vec3d d = p - centre;
    const double r = std::sqrt(d.x() * d.x() + d.y() * d.y()), z = d.z();
    const double distance = std::min({toSegment(r, z, 0, -half, base, -half), toSegment(r, z, base, -half, top, half),
                                      toSegment(r, z, 0, half, top, half)});
    const bool inside = std::abs(z) < half && (r - base) * 2 * half < (top - base) * (z + half);
    return inside ? -distance : distance;
  });
}

Version makeRod(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& fromMm, const Vec3d& toMm, double radiusMm,
                double chamferMm, Job* job) {
  const double lengthMm = (toMm - fromMm).norm();
  if (!(lengthMm > 0) || !(chamferMm >= 0 && chamferMm <= radiusMm && 2 * chamferMm <= lengthMm))
    throw Error(
        fmt::format("rod of radius {} mm and length {} mm with chamfers of {} mm: give a length, and a chamfer "
                    "from 0 to the radius and to half the length",
                    radiusMm, lengthMm, chamferMm));
  const Vec3d axis = (toMm - fromMm) / lengthMm, foot = grid.toVoxel(fromMm);
  const double voxel = grid.voxelMm, length = lengthMm / voxel, radius = radiusMm / voxel, chamfer = chamferMm / voxel;
  const Vec3d half =
      (toMm - fromMm).cwiseAbs() / 2 + radiusMm * (Vec3d::Ones() - axis.cwiseProduct(axis)).cwiseMax(0.0).cwiseSqrt();
  return make(std::move(store), grid, (fromMm + toMm) / 2, half.cwiseMax(voxel), "rod", job, [&](const Vec3d& p) {
    const Vec3d d = p - foot;
    const double along = d.dot(axis), z = std::abs(along - length / 2), r = (d - along * axis).norm(), end = length / 2;
    const double distance = std::min({toSegment(r, z, radius, 0, radius, end - chamfer),
                                      toSegment(r, z, radius, end - chamfer, radius - chamfer, end),
                                      toSegment(r, z, radius - chamfer, end, 0, end)});
    const bool inside = r < radius && z < end && (r - radius) + (z - end) < -chamfer;
    return inside ? -distance : distance;
  });
}

Version makeTorus(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm, double ringMm, double tubeMm,
                  Job* job) {
  if (!(tubeMm <= ringMm))
    throw Error(
        fmt::format("ring of radius {} mm with a tube of {} mm: the tube must not be the larger one", ringMm, tubeMm));
  const Vec3d centre = grid.toVoxel(centreMm);
  const double ring = ringMm / grid.voxelMm, tube = tubeMm / grid.voxelMm;
  return make(std::move(store), grid, centreMm, {ringMm + tubeMm, ringMm + tubeMm, tubeMm}, "ring", job,
              [&](const Vec3d& p) {
                const Vec3d d = p - centre;
                const double r = std::sqrt(d.x() * d.x() + d.y() * d.y()) - ring;
                return std::sqrt(r * r + d.z() * d.z()) - tube;
              });
}

Version makeEllipsoid(std::shared_ptr<Store> store, const Grid& grid, const Vec3d& centreMm, const Vec3d& radiiMm,
                      Job* job) {
  const Vec3d centre = grid.toVoxel(centreMm), radii = radiiMm / grid.voxelMm;
  return make(std::move(store), grid, centreMm, radiiMm, "ellipsoid", job,
              [&](const Vec3d& p) { return toEllipsoid(p - centre, radii); });
}

}  // namespace argil::clay
