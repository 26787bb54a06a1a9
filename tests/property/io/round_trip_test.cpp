// What was written reads back as the same mesh, for every format that is written.
#include <gtest/gtest.h>

#include <random>

#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/weld.h"
#include "io/models/mesh_file.h"
#include "io/models/mesh_writer.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

constexpr uint32_t kSeed = 20261;

struct Way {
  const char* name;
  WriteOptions options;
  bool exact;   ///< Keeps doubles to the bit.
  bool shared;  ///< Keeps vertices and their order; the others weld.
};
const Way kWays[] = {
    {"a.obj", {}, true, true},
    {"b.ply", {}, false, true},
    {"c.ply", {.doubles = true}, true, true},
    {"d.stl", {}, false, false},
    {"e.stl", {.text = true}, false, false},
};

/// Through memory: g++ 12 at -O2 (SLP vectorization) drops a narrowing that is widened again at once.
Vec3d narrowed(const Vec3d& p) {
  volatile float narrow[3];
  Vec3d result;
  for (int axis = 0; axis < 3; ++axis) {
    narrow[axis] = float(p[axis]);
    result[axis] = double(narrow[axis]);
  }
  return result;
}

void expectSame(const clay::TriangleMesh& mesh, const Way& way, const std::filesystem::path& path) {
  const WriteReport report = writeMesh(path, mesh, way.options);
  const clay::TriangleMesh back = readMesh(path).mesh;
  ASSERT_EQ(back.triangles.size(), mesh.triangles.size());
  if (way.shared) {
    EXPECT_EQ(back.triangles, mesh.triangles);
    EXPECT_EQ(back.positions.size(), mesh.positions.size());
  }
  double worst = 0;
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    for (size_t c = 0; c < 3; ++c) {
      const Vec3d expected = mesh.positions[mesh.triangles[t][c]];
      const Vec3d actual = back.positions[back.triangles[t][c]];
      if (way.exact) {
        ASSERT_EQ(actual, expected) << t;
      } else {
        // Text of a 32-bit number, read as 64 bits, is that number only once narrowed again.
        ASSERT_EQ(way.options.text ? narrowed(actual) : actual, narrowed(expected)) << t;
      }
      worst = std::max(worst, ((way.exact ? actual : narrowed(actual)) - expected).cwiseAbs().maxCoeff());
    }
  }
  EXPECT_EQ(report.rounding, worst);
}

TEST(RoundTrip, RandomTrianglesOfEveryMagnitude) {
  std::cout << "seed " << kSeed << "\n";
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> mantissa(-1, 1);
  std::uniform_int_distribution<int> exponent(-60, 60);
  const samples::Folder folder;
  clay::TriangleMesh mesh;
  for (int i = 0; i < 3000; ++i) {
    Vec3d p;
    for (int axis = 0; axis < 3; ++axis) p[axis] = std::ldexp(mantissa(random), exponent(random));
    mesh.positions.push_back(p);
  }
  // Every vertex is used, so that the rounding of the report is that of the triangles.
  for (uint32_t i = 0; i < 3000; i += 3) mesh.triangles.push_back({i, i + 1, i + 2});
  std::uniform_int_distribution<uint32_t> vertex(0, 2999);
  for (int i = 0; i < 4000; ++i) mesh.triangles.push_back({vertex(random), vertex(random), vertex(random)});
  for (const Way& way : kWays) {
    SCOPED_TRACE(way.name);
    expectSame(mesh, way, folder / way.name);
  }
}

TEST(RoundTrip, ClosedStaysClosed) {
  const samples::Folder folder;
  for (const Way& way : kWays) {
    SCOPED_TRACE(way.name);
    expectSame(samples::cube(0.1, {100, -7, 3}), way, folder / way.name);
    const clay::TopologyReport report = clay::checkTopology(readMesh(folder / way.name).mesh);
    EXPECT_TRUE(report.closed());
    EXPECT_NEAR(report.volume, 0.008, 1e-6);
  }
}

TEST(RoundTrip, RealMeshes) {
  const std::filesystem::path data = samples::meshData();
  if (data.empty()) GTEST_SKIP() << "set ARGIL_DATA to the folder of test data";
  const samples::Folder folder;
  for (const char* name :
       {"cycloidal.ply", "gebco7510_55cl_utm.stl", "suzanne.obj", "fandisk.obj", "elephant-with-holes.off"}) {
    clay::TriangleMesh mesh = readMesh(data / name).mesh;
    mesh = clay::weldExact(mesh);  // Only used vertices, as above.
    for (const Way& way : kWays) {
      SCOPED_TRACE(std::string(name) + " as " + way.name);
      expectSame(mesh, way, folder / way.name);
    }
  }
}

}  // namespace
}  // namespace argil::io
