#pragma once
// Measures of what a brush left, for the tests of clay's methods. Lengths in voxels.

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "clay/brush/brush.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/store/sampler.h"
#include "clay/surface/surface.h"

namespace argil::clay::testing {

struct FieldErrors {
  double rms = 0, worst = 0;
  uint64_t voxels = 0;
};

/// |φ| against the distance to the surface that is shown, at voxels within one of it; `worst` away from creases: where
/// the field's gradients within two voxels agree to 20°.
inline FieldErrors fieldErrors(const Version& version) {
  Surface surface(false);
  surface.update(version);
  TriangleMesh mesh = surface.toMesh();
  for (Vec3d& p : mesh.positions) p = version.grid().toVoxel(p);
  const NearestTriangle nearest(mesh);
  Sampler sampler(version);
  FieldErrors errors;
  double sum = 0;
  uint32_t hint = UINT32_MAX;
  version.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < kBrickVoxels; ++i) {
      const float phi = brick.phi(i);
      if (!(std::abs(phi) <= 1)) continue;
      const Vec3d p = (brick.coord * 8 + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d();
      const auto hit = nearest.nearest(p, hint);
      hint = hit.triangle;
      const double error = std::abs(std::abs(double(phi)) - std::sqrt(hit.squared));
      sum += error * error;
      ++errors.voxels;
      if (error <= errors.worst) continue;
      Vec3f own;
      static_cast<void>(sampler.trilinear(p + Vec3d::Constant(1e-3), own));
      bool crease = own.norm() < 0.1f;
      for (int n = 0; n < 125 && !crease; ++n) {
        Vec3f other;
        const float value = sampler.trilinear(p + Vec3d(n / 25 - 2, n / 5 % 5 - 2, n % 5 - 2), other);
        if (std::abs(value) < 2 &&
            (other.norm() < 0.1f || own.dot(other) < std::cos(20 * M_PI / 180) * own.norm() * other.norm()))
          crease = true;
      }
      if (!crease) errors.worst = error;
    }
  });
  errors.rms = std::sqrt(sum / static_cast<double>(std::max<uint64_t>(errors.voxels, 1)));
  return errors;
}

/// The surface is closed; its vertices in voxels.
inline std::vector<Vec3d> closedSurface(const Version& version) {
  Surface surface(false);
  surface.update(version);
  TriangleMesh mesh = surface.toMesh();
  EXPECT_TRUE(checkTopology(mesh).closed());
  for (Vec3d& p : mesh.positions) p = version.grid().toVoxel(p);
  return mesh.positions;
}

/// Stamps along a line, a tenth of the radius apart and at least half a voxel, as a stroke lays them.
inline std::vector<Stamp> line(const Vec3d& from, const Vec3d& to, double radius, float strength = 1) {
  const int count = std::max(1, static_cast<int>(std::ceil((to - from).norm() / std::max(0.1 * radius, 0.5))));
  std::vector<Stamp> stamps;
  for (int i = 0; i < count; ++i)
    stamps.push_back({from + (to - from) * i / count, from + (to - from) * (i + 1) / count, radius, strength});
  return stamps;
}

/// The same along a great circle about z of a sphere around the origin.
inline std::vector<Stamp> arc(double sphere, double from, double to, double radius, float strength = 1) {
  const int count =
      std::max(1, static_cast<int>(std::ceil(sphere * std::abs(to - from) / std::max(0.1 * radius, 0.5))));
  const auto at = [&](int i) {
    const double angle = from + (to - from) * i / count;
    return Vec3d(sphere * std::cos(angle), sphere * std::sin(angle), 0);
  };
  std::vector<Stamp> stamps;
  for (int i = 0; i < count; ++i) stamps.push_back({at(i), at(i + 1), radius, strength});
  return stamps;
}

inline Version apply(const Version& base, std::shared_ptr<const Brush> brush, const std::vector<Stamp>& stamps,
                     int times = 1) {
  BrushStroke stroke(base, std::move(brush));
  for (int i = 0; i < times; ++i)
    for (const Stamp& each : stamps) stroke.apply(each);
  return stroke.finish();
}

}  // namespace argil::clay::testing
