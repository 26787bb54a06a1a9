#include "clay/mesh/winding_number.h"

#include <gtest/gtest.h>

#include "test_meshes.h"

namespace argil::clay {
namespace {

using testing::box;
using testing::dataFile;
using testing::icosphere;
using testing::readMesh;

constexpr uint64_t kSeed = 20261120;

/// Worst difference between tree and sum over points in and around the mesh's box.
double worstError(const TriangleMesh& mesh, int points) {
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  const WindingNumber winding(mesh);
  Vec3d low = mesh.positions[0], high = low;
  for (const auto& p : mesh.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> unit(-0.2, 1.2);
  double worst = 0;
  for (int i = 0; i < points; ++i) {
    const Vec3d p = low + Vec3d(unit(random), unit(random), unit(random)).cwiseProduct(high - low);
    worst = std::max(worst, std::abs(winding.at(p) - winding.exact(p)));
  }
  return worst;
}

TEST(WindingNumber, CountsClosedBodies) {
  TriangleMesh two = icosphere({0, 0, 0}, 10, 3);
  testing::append(two, box({-2, -2, -2}, {30, 2, 2}));
  const WindingNumber winding(two);
  EXPECT_NEAR(winding.at({0, 5, 0}), 1, 1e-2);
  EXPECT_NEAR(winding.at({1, 0, 0}), 2, 1e-2);
  EXPECT_NEAR(winding.at({20, 0, 0}), 1, 1e-2);
  EXPECT_NEAR(winding.at({20, 5, 0}), 0, 1e-2);
  EXPECT_NEAR(winding.exact({1, 0, 0}), 2, 1e-12);
}

TEST(WindingNumber, SumsManyTurnsExactly) {
  // Forty coincident spheres: the angles wrap around many times.
  TriangleMesh many;
  for (int i = 0; i < 40; ++i) testing::append(many, icosphere({0, 0, 0}, 1, 1));
  const WindingNumber winding(many);
  EXPECT_NEAR(winding.exact({0.1, 0.2, 0.3}), 40, 1e-9);
  EXPECT_NEAR(winding.exact({3, 0, 0}), 0, 1e-9);
  for (auto& t : many.triangles) testing::flip(t);
  EXPECT_NEAR(WindingNumber(many).exact({0.1, 0.2, 0.3}), -40, 1e-9);
}

TEST(WindingNumber, IsHalfTheOpenSolidAngleBesideAHole) {
  TriangleMesh open = box({-1, -1, -1}, {1, 1, 1});
  open.triangles.erase(open.triangles.begin() + 2, open.triangles.begin() + 4);  // without the face z = 1
  const WindingNumber winding(open);
  EXPECT_NEAR(winding.at({0, 0, 0}), 5.0 / 6, 1e-9);  // a cube's face takes a sixth of the sphere
}

TEST(WindingNumber, IsDefinedEverywhere) {
  TriangleMesh mesh = box({0, 0, 0}, {1, 1, 1});
  mesh.triangles.push_back({0, 0, 1});  // degenerate
  const WindingNumber winding(mesh);
  for (const auto& p : mesh.positions) EXPECT_TRUE(std::isfinite(winding.at(p)));
  EXPECT_TRUE(std::isfinite(winding.at({0.5, 0.5, 0})));
  EXPECT_EQ(WindingNumber(TriangleMesh{}).at({0, 0, 0}), 0);
  // Close to a face the two sides differ by one.
  EXPECT_NEAR(winding.at({0.3, 0.4, 1e-9}) - winding.at({0.3, 0.4, -1e-9}), 1, 1e-6);
}

TEST(WindingNumber, AgreesWithTheSumOnRandomSoups) {
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal;
  for (const double size : {0.05, 0.3, 3.0}) {
    TriangleMesh soup;
    for (uint32_t i = 0; i < 500; ++i) {
      const Vec3d c(normal(random), normal(random), normal(random));
      for (int k = 0; k < 3; ++k)
        soup.positions.push_back(c + size * Vec3d(normal(random), normal(random), normal(random)));
      soup.triangles.push_back({3 * i, 3 * i + 1, 3 * i + 2});
    }
    EXPECT_LE(worstError(soup, 2000), 0.01) << "seed " << kSeed << ", triangle size " << size;
  }
}

TEST(WindingNumber, AgreesWithTheSumOnRealMeshes) {
  if (dataFile("").empty()) GTEST_SKIP() << "ARGIL_DATA is not set";
  for (const char* name : {"mesh/stanford-bunny.obj", "mesh/cycloidal.ply", "mesh/fandisk.obj", "cad/bearing.stl"}) {
    const double worst = worstError(readMesh(dataFile(name)), 300);
    EXPECT_LE(worst, 0.01) << name;
    RecordProperty(name, std::to_string(worst));
  }
}

}  // namespace
}  // namespace argil::clay
