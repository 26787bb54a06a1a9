#pragma once
// Checks of whole-piece operations: error against a known distance, closed surfaces.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <string>

#include <fmt/format.h>

#include "clay/mesh/mesh_topology.h"
#include "clay/store/version.h"
#include "clay/surface/surface.h"

namespace argil::clay::testing {

/// Differences from an exact distance, in voxels: where |exact| ≤ 1, and where it is below the band less half a voxel.
struct FieldError {
  double surfaceRms = 0, surfaceMax = 0, bandRms = 0, bandMax = 0;
  uint64_t surface = 0, inBand = 0;
  [[nodiscard]] std::string text() const {
    return fmt::format("near the surface {:.4f} RMS {:.4f} max, in the band {:.4f} RMS {:.4f} max", surfaceRms,
                       surfaceMax, bandRms, bandMax);
  }
};

/// `exactMm` takes world mm.
inline FieldError errorAgainst(const Version& version, const std::function<double(const Vec3d&)>& exactMm) {
  FieldError e;
  const Grid& grid = version.grid();
  version.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < kBrickVoxels; ++i) {
      const Coord v = brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
      const double exact = exactMm(grid.toWorld(v.toVec3d())) / grid.voxelMm;
      if (std::abs(exact) > double(grid.band) - 0.5) continue;
      const double d = std::abs(double(brick.phi(i)) - exact);
      e.bandMax = std::max(e.bandMax, d);
      e.bandRms += d * d;
      ++e.inBand;
      if (std::abs(exact) > 1) continue;
      e.surfaceMax = std::max(e.surfaceMax, d);
      e.surfaceRms += d * d;
      ++e.surface;
    }
  });
  e.bandRms = std::sqrt(e.bandRms / double(std::max<uint64_t>(e.inBand, 1)));
  e.surfaceRms = std::sqrt(e.surfaceRms / double(std::max<uint64_t>(e.surface, 1)));
  EXPECT_GT(e.surface, 0u);
  return e;
}

inline void expectClosed(const Version& version, int bodies = 1) {
  Surface surface(false);
  surface.update(version, 2);
  const TopologyReport topology = checkTopology(surface.toMesh());
  EXPECT_TRUE(topology.closed());
  if (bodies > 0) {
    EXPECT_EQ(topology.bodies, static_cast<uint64_t>(bodies));
  }
}

}  // namespace argil::clay::testing
