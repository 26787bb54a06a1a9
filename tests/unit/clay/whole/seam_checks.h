#pragma once
// Bodies, voids, area and volume of a clay, beside the right ones.

#include <gtest/gtest.h>

#include "clay/field/loose_parts.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/surface/surface.h"

namespace argil::clay::testing {

/// Of the surface in the crisp grade, which has sharp edges.
inline TopologyReport measured(const Version& version) {
  Surface surface(false, Grade::crisp);
  surface.update(version, 2);
  return checkTopology(surface.toMesh());
}

/// One body without voids, of that area and volume (mm², mm³; parts of them).
inline void expectOneBody(const Version& version, double area, double volume, double areaOff = 0.005,
                          double volumeOff = 0.001) {
  EXPECT_EQ(bodyVolumes(version).size(), 1u);
  EXPECT_EQ(fillVoids(version).count, 0u);
  const TopologyReport report = measured(version);
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.bodies, 1u);
  EXPECT_NEAR(report.area / area, 1, areaOff);
  EXPECT_NEAR(report.volume / volume, 1, volumeOff);
}

/// Compares a clay with one that never was in parts. `lost`: mm³ that an operation said it lost, some of which may have
/// come back; the faces of what is lost were about as large as what lies open now.
inline void expectAsOne(const Version& version, const Version& whole, double lost = 0, double volumeOff = 0.001) {
  const TopologyReport right = measured(whole);
  expectOneBody(version, right.area, right.volume - lost / 2, lost > 0 ? 0.01 : 0.005,
                volumeOff + lost / 2 / right.volume);
}

}  // namespace argil::clay::testing
