// Clay that follows a map of space: how exact it is, and that it stays a solid.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/deform.h"
#include "clay/whole/lattice.h"
#include "tests/unit/clay/clay_checks.h"
#include "tests/unit/clay/field_compare.h"

namespace argil::clay {
namespace {

using testing::FieldError;
using testing::fieldError;

constexpr double kPi = 3.141592653589793;

void print(const char* what, const FieldError& e, double within) {
  std::printf("  %s: %.4f voxel RMS, %.3f worst within %.1f voxels of the surface (%llu voxels)\n", what, e.rms,
              e.worst, within, static_cast<unsigned long long>(e.voxels));
}

TriangleMesh meshOf(const Version& version) {
  Surface surface;
  surface.update(version);
  return surface.toMesh();
}

Version sphere(double radius = 20) {
  return makeSphere(Store::make(), Grid{}, Vec3d::Zero(), radius);
}

void expectSolid(const Version& version, uint64_t bodies = 1, double steepest = 1.3) {
  const auto faults = testing::bandFaults(version);
  EXPECT_LE(faults.steepest, steepest);
  EXPECT_EQ(faults.besideTile, 0u);
  const TopologyReport report = checkTopology(meshOf(version));
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.bodies, bodies);
}

Lattice affine(const BoxMm& piece, const Eigen::Matrix3d& by) {
  Lattice lattice = Lattice::around(piece);
  for (size_t i = 0; i < lattice.points().size(); ++i) lattice.setPoint(i, by * lattice.restPoint(i));
  return lattice;
}

TEST(Deform, AnAffineLatticeMakesASphereTheExactEllipsoid) {
  const Version ball = sphere();
  for (const Vec3d& factors : {Vec3d(1.5, 1, 0.7), Vec3d(1, 1, 1), Vec3d(0.4, 1.2, 1), Vec3d(2.5, 2, 1)}) {
    const Version deformed = deform(ball, affine(brickBoundsOf(ball), factors.asDiagonal()), Store::make());
    const Version exact = makeEllipsoid(Store::make(), Grid{}, Vec3d::Zero(), 20 * factors);
    const FieldError beside = fieldError(deformed, exact, 1), band = fieldError(deformed, exact, 2.9);
    std::printf("scaled by %g %g %g\n", factors.x(), factors.y(), factors.z());
    print("beside", beside, 1);
    print("band", band, 2.9);
    EXPECT_LE(beside.rms, 0.002);
    EXPECT_LE(band.worst, 0.15);
    expectSolid(deformed);
  }
}

TEST(Deform, ATurnedBlockIsTheTurnedBlock) {
  const Vec3d half(16, 10, 6);
  const Version block = makeBlock(Store::make(), Grid{}, Vec3d::Zero(), 2 * half, 0);
  const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.5, Vec3d(1, 2, 3).normalized()).toRotationMatrix();
  const Version turned = deform(block, affine(brickBoundsOf(block), turn), Store::make());
  const auto exact = [&](const Vec3d& p) {
    const Vec3d q = (turn.transpose() * p).cwiseAbs() - 2 * half;
    return q.cwiseMax(0.0).norm() + std::min(q.maxCoeff(), 0.0);
  };
  // Creases are as round as interpolation makes them; away from them nothing is lost.
  const auto offCrease = [&](const Vec3d& p) {
    const Vec3d q = ((turn.transpose() * p).cwiseAbs() - 2 * half).cwiseAbs();
    return (q.array() < 5).count() <= 1;
  };
  print("faces", fieldError(turned, exact, 2.9, offCrease), 2.9);
  print("all beside", fieldError(turned, exact, 1), 1);
  print("all band", fieldError(turned, exact, 2.9), 2.9);
  EXPECT_LE(fieldError(turned, exact, 2.9, offCrease).worst, 0.05);
  EXPECT_LE(fieldError(turned, exact, 1).rms, 0.1);
  expectSolid(turned);
}

TEST(Deform, TwistedThereAndBackIsWhatItWas) {
  const Version block = makeBlock(Store::make(), Grid{}, Vec3d::Zero(), Vec3d(24, 16, 60), 3);
  const WarpAxis axis{Vec3d(0, 0, 0), Vec3d::UnitZ(), -25, 25};
  const Version twisted = deform(block, Twist(axis, kPi / 2), Store::make());
  expectSolid(twisted);
  EXPECT_NEAR(testing::clayVolume(twisted) / testing::clayVolume(block), 1, 2e-3);
  const Version back = deform(twisted, Twist(axis, -kPi / 2), Store::make());
  const FieldError error = fieldError(back, block, 1);
  print("twist back", error, 1);
  print("twist back band", fieldError(back, block, 2.9), 2.9);
  EXPECT_LE(error.rms, 0.005);
  expectSolid(back);
}

TEST(Deform, ABentRodIsAPieceOfARing) {
  // A rod of length L bent by a full angle less 0.2: a torus where its ends are away.
  const double radius = 6, length = 200, angle = 5;
  const Version rod = makeCylinder(Store::make(), Grid{}, Vec3d::Zero(), radius, length, 2);
  const Version bent =
      deform(rod, Bend({Vec3d::Zero(), Vec3d::UnitZ(), -length / 2 + 10, length / 2 - 10}, Vec3d::UnitX(), angle),
             Store::make());
  const double ring = (length - 20) / angle;
  const Vec3d centre(ring, 0, -length / 2 + 10);
  const auto exact = [&](const Vec3d& voxel) {
    const Vec3d p = voxel * 0.5 - centre;
    const double r = std::sqrt(p.x() * p.x() + p.z() * p.z()) - ring;
    return (std::sqrt(r * r + p.y() * p.y()) - radius) * 2;
  };
  const auto amidst = [&](const Vec3d& voxel) {
    const Vec3d p = voxel * 0.5 - centre;
    const double at = std::atan2(p.z(), -p.x());
    return at > 0.3 && at < kPi;
  };
  const FieldError beside = fieldError(bent, exact, 1, amidst), band = fieldError(bent, exact, 2.9, amidst);
  print("bend", beside, 1);
  print("bend band", band, 2.9);
  EXPECT_GT(beside.voxels, 1000u);
  EXPECT_LE(beside.rms, 0.002);
  EXPECT_LE(band.worst, 0.02);
  expectSolid(bent);
}

TEST(Deform, RandomLatticesLeaveOneClosedSolidWithAProperBand) {
  const uint64_t seed = 20;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  const Version block = makeBlock(Store::make(), Grid{}, Vec3d(3, 4, 5), Vec3d(40, 30, 20), 2);
  int made = 0;
  for (int i = 0; i < 12; ++i) {
    const std::array<int, 3> counts{2 + static_cast<int>(random() % 4), 2 + static_cast<int>(random() % 4),
                                    2 + static_cast<int>(random() % 4)};
    Lattice lattice = Lattice::around(brickBoundsOf(block), counts);
    for (size_t k = 0; k < lattice.points().size(); ++k)
      lattice.setPoint(k, lattice.restPoint(k) + 4 * Vec3d(u(random), u(random), u(random)));
    try {
      const Version deformed = deform(block, lattice, Store::make());
      SCOPED_TRACE(::testing::Message() << "seed " << seed << " number " << i);
      expectSolid(deformed);
      ++made;
    } catch (const Error& e) {
      EXPECT_NE(std::string(e.what()).find("deformation"), std::string::npos) << e.what();
    }
  }
  std::printf("%d of 12 made\n", made);
  EXPECT_GE(made, 6);
}

TEST(Deform, ClayThatComesOverClayIsUnited) {
  // The straight ends of a rod bent by nearly a turn lie in its own beginning and end: a ring, no cavity between.
  const double length = 120, radius = 6;
  const Version rod = makeCylinder(Store::make(), Grid{}, Vec3d::Zero(), radius, length, 2);
  const Version bent = deform(rod, Bend({Vec3d::Zero(), Vec3d::UnitZ(), -45, 45}, Vec3d::UnitX(), 6.2), Store::make());
  expectSolid(bent);
  const TopologyReport report = checkTopology(meshOf(bent));
  // A ring: Euler's number is zero.
  EXPECT_EQ(static_cast<int64_t>(report.vertices) - static_cast<int64_t>(report.triangles) / 2, 0);
}

TEST(Deform, EqualBitsOnAnyNumberOfThreads) {
  const Version ball = sphere();
  Lattice lattice = Lattice::around(brickBoundsOf(ball));
  lattice.drag({20, 0, 0}, {8, 3, 0});
  const uint64_t one = deform(ball, lattice, Store::make(), nullptr, 1).hash();
  for (const int threads : {2, 3, 8})
    EXPECT_EQ(deform(ball, lattice, Store::make(), nullptr, threads).hash(), one) << threads;
}

}  // namespace
}  // namespace argil::clay
