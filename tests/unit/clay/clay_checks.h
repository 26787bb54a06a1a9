#pragma once
// What must hold of every version, and measures of one, for the tests of clay.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "clay/store/sampler.h"
#include "clay/store/version.h"

namespace argil::clay::testing {

/// A copy of a brick's distances.
inline std::array<float, kBrickVoxels> valuesOf(const Brick& brick) {
  std::array<float, kBrickVoxels> values;
  brick.read(0, kBrickVoxels, values.data());
  return values;
}

/// Volume in voxels³ from the field alone: a voxel counts with 1/2 − phi, between 0 and 1, which is right on average
/// for a plane of any direction.
inline double clayVolume(const Version& version) {
  Coord low{INT32_MAX, INT32_MAX, INT32_MAX}, high{INT32_MIN, INT32_MIN, INT32_MIN};
  double volume = 0;
  version.forEachBrick([&](const Brick& brick) {
    const Coord c = brick.coord;
    low = {std::min(low.x, c.x), std::min(low.y, c.y), std::min(low.z, c.z)};
    high = {std::max(high.x, c.x), std::max(high.y, c.y), std::max(high.z, c.z)};
    for (const float phi : valuesOf(brick)) volume += std::clamp(0.5 - double(phi), 0.0, 1.0);
  });
  for (int x = low.x; x <= high.x; ++x) {
    for (int y = low.y; y <= high.y; ++y) {
      for (int z = low.z; z <= high.z; ++z) {
        const Slot slot = version.find({x, y, z});
        if (slot.isTile() && slot.tile() == Tile::inside) volume += kBrickVoxels;
      }
    }
  }
  return volume;
}

struct BandFaults {
  double steepest = 0;      ///< Largest difference between neighbours, voxels.
  uint64_t besideTile = 0;  ///< Sign changes with an end that is not in the band.
  uint64_t crossings = 0;   ///< Voxel edges with a sign change.
};

/// Looks at every pair of neighbours of which one lies in a brick.
inline BandFaults bandFaults(const Version& version) {
  BandFaults faults;
  Sampler sampler(version);
  const float band = version.grid().band;
  version.forEachBrick([&](const Brick& brick) {
    for (int x = 0; x < 8; ++x) {
      for (int y = 0; y < 8; ++y) {
        for (int z = 0; z < 8; ++z) {
          const Coord v = brick.coord * 8 + Coord{x, y, z};
          const float phi = brick.phi(Brick::offset(x, y, z));
          for (int side = 0; side < 6; ++side) {
            const int s = side & 1 ? -1 : 1;
            const Coord n = v + Coord{side / 2 == 0 ? s : 0, side / 2 == 1 ? s : 0, side / 2 == 2 ? s : 0};
            const float other = sampler.voxel(n);
            faults.steepest = std::max(faults.steepest, double(std::abs(phi - other)));
            if ((phi < 0) == (other < 0)) continue;
            ++faults.crossings;
            if (std::abs(phi) >= band || std::abs(other) >= band) ++faults.besideTile;
          }
        }
      }
    }
  });
  return faults;
}

/// `steepest`: 1 for exact distances; first-order ones beside closed holes and folds are allowed more.
inline void expectProperBand(const Version& version, double steepest = 1.001) {
  const BandFaults faults = bandFaults(version);
  EXPECT_LE(faults.steepest, steepest);
  EXPECT_EQ(faults.besideTile, 0u);
  EXPECT_GT(faults.crossings, 0u);
}

}  // namespace argil::clay::testing
