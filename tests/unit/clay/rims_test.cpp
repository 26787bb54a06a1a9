// Rims of ball cuts, the commonest crease there is: the live grade against the circles that are known exactly.

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "tests/unit/clay/sharp_shapes.h"

namespace argil::clay {
namespace {

using namespace testing;

constexpr double kTip = 10;  // Voxels: a ball of 5 mm at 0.5 mm.

struct Rim {
  Version clay;
  std::vector<Vec3d> points;                     // of the circle
  std::function<double(const Vec3d&)> distance;  // zero on the surface of the solid near the cut
  Vec3d centre;                                  // of the ball
};

// A ball cut into the flat side of a block, its centre `above` the surface. Turned and placed at random.
Rim cutIntoPlane(std::mt19937_64& random, double above) {
  std::uniform_real_distribution<double> shift(-1, 1);
  TurnedBox box;
  box.axes = randomTurn(random);
  const Vec3d middle(shift(random), shift(random), shift(random)), up = box.axes.col(2);
  box.half = Vec3d(20, 20, 10);
  box.centre = middle - 10 * up;
  const Version block = clayOf(Store::make(), 32, [&](const Vec3d& p) { return box.distance(p); });
  Rim rim;
  rim.centre = middle + above * up;
  const double radius = std::sqrt(kTip * kTip - above * above);
  for (int i = 0; i < 400; ++i) {
    const double turn = 2 * EIGEN_PI * i / 400;
    rim.points.push_back(middle + radius * (std::cos(turn) * box.axes.col(0) + std::sin(turn) * box.axes.col(1)));
  }
  rim.distance = [=, centre = rim.centre](const Vec3d& p) {
    return std::max((p - middle).dot(up), kTip - (p - centre).norm());
  };
  BrushStroke stroke(block, Brush::of(Method::carve));
  stroke.apply(Stamp{rim.centre, rim.centre, kTip});
  rim.clay = stroke.finish();
  return rim;
}

// The same into a sphere of 40 voxels.
Rim cutIntoSphere(std::mt19937_64& random, double above) {
  constexpr double kSphere = 40;
  std::uniform_real_distribution<double> shift(-1, 1);
  const Eigen::Matrix3d axes = randomTurn(random);
  const Vec3d pole(shift(random), shift(random), shift(random)), up = axes.col(2), middle = pole - kSphere * up;
  Grid grid;
  grid.voxelMm = 1;
  Rim rim;
  rim.centre = pole + above * up;
  const double apart = kSphere + above, height = (apart * apart + kSphere * kSphere - kTip * kTip) / (2 * apart),
               radius = std::sqrt(kSphere * kSphere - height * height);
  for (int i = 0; i < 400; ++i) {
    const double turn = 2 * EIGEN_PI * i / 400;
    rim.points.push_back(middle + height * up + radius * (std::cos(turn) * axes.col(0) + std::sin(turn) * axes.col(1)));
  }
  rim.distance = [=, centre = rim.centre](const Vec3d& p) {
    return std::max((p - middle).norm() - kSphere, kTip - (p - centre).norm());
  };
  BrushStroke stroke(makeSphere(Store::make(), grid, middle, kSphere), Brush::of(Method::carve));
  stroke.apply(Stamp{rim.centre, rim.centre, kTip});
  rim.clay = stroke.finish();
  return rim;
}

// Voxels: of the circles' points from the surface, and of the surface's vertices around the cut from the solid.
struct Off {
  double squares = 0, most = 0, vertexMost = 0;
  size_t points = 0;
  std::vector<double> all;

  void look(const Rim& rim, Grade grade) {
    const TriangleMesh mesh = meshOf(rim.clay, grade);
    ASSERT_TRUE(checkTopology(mesh).closed());
    const NearestTriangle tree(mesh);
    for (const Vec3d& p : rim.points) {
      const double squared = tree.nearest(p).squared;
      squares += squared;
      all.push_back(std::sqrt(squared));
      most = std::max(most, all.back());
      ++points;
    }
    for (const Vec3d& p : mesh.positions)
      if ((p - rim.centre).norm() < kTip + 3) vertexMost = std::max(vertexMost, std::abs(rim.distance(p)));
  }
  [[nodiscard]] double rms() const { return std::sqrt(squares / static_cast<double>(points)); }
  [[nodiscard]] double quantile(double q) {
    std::sort(all.begin(), all.end());
    return all[static_cast<size_t>(q * static_cast<double>(all.size() - 1))];
  }
};

// Places off the grid; the ball's centre up to half of its radius above or below the surface, so that the clay's edge
// has 60° to 120°.
TEST(Rims, TheLiveGradeHasThemWhereTheyAre) {
  const uint64_t seed = 11;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> above(-0.5 * kTip, 0.5 * kTip);
  const int places = std::getenv("ARGIL_LONG") ? 100 : 25;
  for (const bool sphere : {false, true}) {
    Off draft, crisp, fine;
    for (int i = 0; i < places; ++i) {
      const double by = above(random);
      const Rim rim = sphere ? cutIntoSphere(random, by) : cutIntoPlane(random, by);
      draft.look(rim, Grade::draft);
      crisp.look(rim, Grade::crisp);
      fine.look(rim, Grade::fine);
    }
    const auto print = [&](const char* grade, Off& off) {
      std::printf("%s, %s: %.3f RMS, 99 %% within %.2f, %.2f at most; vertices %.2f\n", sphere ? "sphere" : "plane",
                  grade, off.rms(), off.quantile(0.99), off.most, off.vertexMost);
    };
    print("draft", draft);
    print("crisp", crisp);
    print("fine", fine);
    EXPECT_LE(crisp.rms(), 0.10) << "seed " << seed;
    EXPECT_LE(crisp.quantile(0.99), 0.5);
    EXPECT_LE(crisp.vertexMost, 0.6);
    EXPECT_GE(draft.rms(), 4 * crisp.rms());
  }
}

// Vertices whose normals say that they stand on a crease. No number is −32768, which readers take for −32767.
size_t onCreases(const Surface& surface) {
  size_t count = 0;
  surface.forEach([&](const BrickMesh& mesh) {
    for (const PackedNormal normal : mesh.normals) {
      EXPECT_GT(normal.u, -32768);
      EXPECT_GT(normal.v, -32768);
      count += normal.v % 2 != 0 ? 1 : 0;
    }
  });
  return count;
}

// Smooth clay has the draft's vertices, to the bit: nothing there looks like a crease.
TEST(Rims, SmoothClayIsTheDrafts) {
  Grid grid;
  grid.voxelMm = 1;
  const Version version = makeSphere(Store::make(), grid, Vec3d(0.3, -0.2, 0.1), 30);
  Surface draft(true, Grade::draft), crisp(true, Grade::crisp);
  draft.update(version);
  crisp.update(version);
  EXPECT_EQ(draft.hash(), crisp.hash());
  EXPECT_EQ(onCreases(crisp), 0u);
}

// Faces that look along an axis have their normals at the ends of what the numbers hold.
TEST(Rims, NormalsSayWhichVerticesAreOnACrease) {
  Grid grid;
  grid.voxelMm = 1;
  const Version box = makeBlock(Store::make(), grid, Vec3d(0.3, -0.2, 0.1), Vec3d(20, 20, 20), 0);
  Surface draft(true, Grade::draft), crisp(true, Grade::crisp);
  draft.update(box);
  crisp.update(box);
  EXPECT_EQ(onCreases(draft), 0u);
  // Twelve edges of twenty voxels.
  EXPECT_GT(onCreases(crisp), 12u * 18);
  EXPECT_LT(onCreases(crisp), 12u * 24);
}

}  // namespace
}  // namespace argil::clay
