#pragma once
// Clay for contact tests, from any signed distance function, and the slow truth to compare with.

#include <cmath>
#include <cstdint>
#include <functional>
#include <limits>
#include <memory>

#include "clay/store/editor.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/store/version.h"

namespace argil::haptics::testing {

/// Voxel coordinates to distance in voxels.
using Field = std::function<double(const Vec3d&)>;

/// A version that samples `field` at the voxels of [-half, half)³ bricks; outside of them all is outside.
inline clay::Version makeClay(const Field& field, int half, double voxelMm = 0.5) {
  clay::Grid grid;
  grid.voxelMm = voxelMm;
  auto store = clay::Store::make();
  clay::Editor editor(clay::Version::empty(store, grid));
  float phi[clay::kBrickVoxels];
  for (int bx = -half; bx < half; ++bx)
    for (int by = -half; by < half; ++by)
      for (int bz = -half; bz < half; ++bz) {
        const Coord brick{bx, by, bz};
        for (int i = 0; i < clay::kBrickVoxels; ++i) {
          const Coord v = brick * 8 + Coord{i >> 6, (i >> 3) & 7, i & 7};
          phi[i] = static_cast<float>(field(v.toVec3d()));
        }
        editor.setVoxels(brick, std::span<const float, clay::kBrickVoxels>(phi));
      }
  return editor.commit();
}

/// Distance from p to the trilinear zero surface by trying every cell within `reach`, `finer` points along each of its
/// inner edges: sign changes of the finer lattice are met linearly. Infinity when there is none. Shares nothing with
/// ClosestSurface.
inline double bruteDistance(const clay::Version& version, const Vec3d& p, double reach, int finer = 6) {
  clay::Sampler sampler(version);
  double best2 = std::numeric_limits<double>::infinity();
  const Coord low{static_cast<int>(std::floor(p.x() - reach)) - 1, static_cast<int>(std::floor(p.y() - reach)) - 1,
                  static_cast<int>(std::floor(p.z() - reach)) - 1};
  const int n = static_cast<int>(2 * reach) + 4;
  for (int x = 0; x < n; ++x)
    for (int y = 0; y < n; ++y)
      for (int z = 0; z < n; ++z) {
        const Coord v = low + Coord{x, y, z};
        const Vec3d middle = v.toVec3d() + Vec3d::Constant(0.5);
        const double nearest = std::max(0.0, (middle - p).norm() - 0.87);
        if (nearest > reach || nearest * nearest > best2) continue;
        double c[2][2][2];
        int negative = 0;
        for (int i = 0; i < 8; ++i) {
          c[i >> 2][(i >> 1) & 1][i & 1] = double(sampler.voxel(v + Coord{i >> 2, (i >> 1) & 1, i & 1}));
          negative += c[i >> 2][(i >> 1) & 1][i & 1] < 0;
        }
        if (negative == 0 || negative == 8) continue;
        const auto value = [&](double a, double b, double d) {
          double sum = 0;
          for (int i = 0; i < 8; ++i)
            sum += c[i >> 2][(i >> 1) & 1][i & 1] * ((i >> 2) ? a : 1 - a) * (((i >> 1) & 1) ? b : 1 - b) *
                   ((i & 1) ? d : 1 - d);
          return sum;
        };
        const double h = 1.0 / finer;
        for (int a = 0; a <= finer; ++a)
          for (int b = 0; b <= finer; ++b)
            for (int axis = 0; axis < 3; ++axis) {
              double before = 0;
              for (int s = 0; s <= finer; ++s) {
                Vec3d q;
                q[axis] = s * h;
                q[(axis + 1) % 3] = a * h;
                q[(axis + 2) % 3] = b * h;
                const double now = value(q.x(), q.y(), q.z());
                if (s && (now < 0) != (before < 0)) {
                  Vec3d at = q;
                  at[axis] += h * (before / (before - now) - 1);
                  best2 = std::min(best2, (v.toVec3d() + at - p).squaredNorm());
                }
                before = now;
              }
            }
      }
  return std::sqrt(best2);
}

/// A repeatable value in [-1, 1] for a lattice point.
inline double noiseAt(int x, int y, int z, uint32_t seed) {
  uint32_t h = seed ^ (static_cast<uint32_t>(x) * 0x8da6b343u) ^ (static_cast<uint32_t>(y) * 0xd8163841u) ^
               (static_cast<uint32_t>(z) * 0xcb1ab31fu);
  h ^= h >> 13;
  h *= 0x5bd1e995u;
  h ^= h >> 15;
  h *= 0x2c1b3c6du;
  h ^= h >> 12;
  return double(h) / 2147483647.5 - 1;
}

/// Smooth noise of that wavelength in voxels.
inline double smoothNoise(const Vec3d& p, double wavelength, uint32_t seed) {
  const Vec3d q = p / wavelength;
  const int x = static_cast<int>(std::floor(q.x())), y = static_cast<int>(std::floor(q.y())),
            z = static_cast<int>(std::floor(q.z()));
  const auto ease = [](double t) { return t * t * (3 - 2 * t); };
  const double fx = ease(q.x() - x), fy = ease(q.y() - y), fz = ease(q.z() - z);
  double sum = 0;
  for (int i = 0; i < 8; ++i)
    sum += noiseAt(x + (i >> 2), y + ((i >> 1) & 1), z + (i & 1), seed) * ((i >> 2) ? fx : 1 - fx) *
           (((i >> 1) & 1) ? fy : 1 - fy) * ((i & 1) ? fz : 1 - fz);
  return sum;
}

inline Field planeField(const Vec3d& normal, double offset) {
  return [n = normal.normalized(), offset](const Vec3d& p) { return n.dot(p) - offset; };
}
inline Field sphereField(const Vec3d& centre, double radius) {
  return [=](const Vec3d& p) { return (p - centre).norm() - radius; };
}
/// A V-shaped groove along y in the half-space z < 0, walls at 45°.
inline Field grooveField(double depth) {
  return [=](const Vec3d& p) { return std::max(p.z(), (p.z() + depth - std::abs(p.x())) * std::sqrt(0.5)); };
}
/// A ball carved out of the half-space z < 0: at its rim the field is only a bound.
inline Field rimField(double radius, double depth) {
  return [=](const Vec3d& p) { return std::max(p.z(), radius - (p - Vec3d(0, 0, radius - depth)).norm()); };
}
inline Field noiseField(uint32_t seed, double amplitude, double wavelength) {
  return [=](const Vec3d& p) { return p.z() + amplitude * smoothNoise(p, wavelength, seed); };
}

}  // namespace argil::haptics::testing
