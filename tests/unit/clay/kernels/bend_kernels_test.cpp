// Where a bent surface crosses the edges of a cell, beside plain arithmetic.

#include "clay/kernels/bend_kernels.h"

#include <gtest/gtest.h>

#include <array>
#include <bit>
#include <cmath>
#include <functional>
#include <random>
#include <string>

#include "clay/base/vec.h"
#include "clay/kernels/cell_cases.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

constexpr int kSide = 6, kStepY = kSide + 1, kStepX = kSide * kStepY + 3;  // two voxels around a cell

struct Cell {
  std::array<float, kSide * kStepX> phi{};
  const float* low = &phi[2 * kStepX + 2 * kStepY + 2];
  unsigned edges = 0;
  explicit Cell(const std::function<double(const Vec3d&)>& field) {
    for (int x = 0; x < kSide; ++x)
      for (int y = 0; y < kSide; ++y)
        for (int z = 0; z < kSide; ++z)
          phi[size_t(x * kStepX + y * kStepY + z)] = float(field(Vec3d(x - 2, y - 2, z - 2)));
    for (size_t e = 0; e < 12; ++e) edges |= unsigned{inside(kCellEdges[e].from) != inside(kCellEdges[e].to)} << e;
  }
  Cell(const Cell&) = delete;
  [[nodiscard]] bool inside(int c) const { return low[(c >> 2) * kStepX + (c >> 1 & 1) * kStepY + (c & 1)] < 0; }
};

Vec3d placeOf(const CellEdge& edge, double along) {
  Vec3d p(edge.from >> 2, edge.from >> 1 & 1, edge.from & 1);
  p[edge.axis] += along;
  return p;
}

// Where the cubic through four voxels along an edge is zero.
double zeroOf(const Cell& cell, const CellEdge& edge) {
  const int step = edge.axis == 0 ? kStepX : edge.axis == 1 ? kStepY : 1;
  const float* from = cell.low + (edge.from >> 2) * kStepX + (edge.from >> 1 & 1) * kStepY + (edge.from & 1);
  const auto at = [&](double t) {
    double value = 0;
    for (int i = -1; i <= 2; ++i) {
      double w = double(from[i * step]);
      for (int j = -1; j <= 2; ++j)
        if (j != i) w *= (t - j) / (i - j);
      value += w;
    }
    return value;
  };
  double low = 0, high = 1;
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    ((at(middle) < 0) == (at(low) < 0) ? low : high) = middle;
  }
  return low;
}

// Balls of eight voxels and more: the cubic is within a thousandth of a voxel of them, the normal within half a degree.
TEST(BendKernels, CrossingsOfBallsAreOnThem) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> any(0, 1);
  int crossings = 0;
  for (int round = 0; round < 500; ++round) {
    const double radius = 8 + 40 * any(random);
    const Vec3d way = Vec3d(normal(random), normal(random), normal(random)).normalized(),
                centre = Vec3d(any(random), any(random), any(random)) - radius * way;
    const Cell cell([&](const Vec3d& p) { return (p - centre).norm() - radius; });
    if (cell.edges == 0) continue;
    EdgeCrossings first;
    tests::forEachSimdTarget([&](const std::string& name) {
      EdgeCrossings found;
      ASSERT_TRUE(crossEdges(cell.low, kStepX, kStepY, cell.edges, found)) << name;
      ASSERT_EQ(found.count, std::popcount(cell.edges));
      int k = 0;
      for (unsigned left = cell.edges; left != 0; left &= left - 1, ++k) {
        const CellEdge edge = kCellEdges[size_t(std::countr_zero(left))];
        const Vec3d p = placeOf(edge, double(found.along[k])), outwards = (p - centre).normalized();
        if (std::abs(outwards[edge.axis]) < 0.15) continue;  // an edge that grazes the ball
        EXPECT_LT(std::abs((p - centre).norm() - radius), 1e-3) << name << " " << radius;
        EXPECT_NEAR(double(found.along[k]), zeroOf(cell, edge), 2e-5) << name << " " << radius;
        Vec3d n;
        for (int i = 0; i < 3; ++i) n[(edge.axis + i) % 3] = double(found.normal[i][k]);
        EXPECT_NEAR(n.norm(), 1, 1e-6);
        EXPECT_GT(n.dot(outwards), std::cos(0.5 * M_PI / 180)) << name << " " << radius;
        if (first.count == 0) continue;
        EXPECT_EQ(found.along[k], first.along[k]) << name;
        for (int i = 0; i < 3; ++i) EXPECT_EQ(found.normal[i][k], first.normal[i][k]) << name;
      }
      if (first.count == 0) first = found;
      crossings += found.count;
    });
  }
  EXPECT_GT(crossings, 1000);
}

// A crease that passes the cell a little beside its crossed edges: what is seen from the smooth side is exact, where
// differences across the kink would tilt the normal by degrees.
TEST(BendKernels, AKinkIsSeenFromItsSmoothSide) {
  int seen = 0;
  for (const bool turned : {false, true})
    for (double at = 0.03; at < 0.4; at += 0.03) {
      // Turned round, the crease is on the other side of the crossed edges.
      const auto turn = [turned](const Vec3d& p) { return turned ? Vec3d(1 - p.x(), p.y(), p.z()) : p; };
      const Vec3d a = Vec3d(1, 0.08, 0.05).normalized(), b = Vec3d(0.3, 1, 0.1).normalized(), edge(at, 1.4, 0);
      const Cell cell([&](const Vec3d& p) { return std::max(a.dot(turn(p) - edge), b.dot(turn(p) - edge)); });
      EdgeCrossings found;
      ASSERT_TRUE(crossEdges(cell.low, kStepX, kStepY, cell.edges, found));
      int k = 0;
      for (unsigned left = cell.edges; left != 0; left &= left - 1, ++k) {
        const CellEdge crossed = kCellEdges[size_t(std::countr_zero(left))];
        if (crossed.axis != 0) continue;
        ++seen;
        EXPECT_NEAR(a.dot(turn(placeOf(crossed, double(found.along[k]))) - edge), 0, 1e-5) << at;
        const Vec3d normal((turned ? -1 : 1) * double(found.normal[0][k]), double(found.normal[1][k]),
                           double(found.normal[2][k]));
        EXPECT_GT(normal.dot(a), 1 - 1e-4) << at;
      }
    }
  EXPECT_GE(seen, 40);
}

TEST(BendKernels, AFieldWithoutSlopeHasNoSurface) {
  for (const double slope : {0.02, 0.5}) {
    const Cell cell([&](const Vec3d& p) { return slope * (p.x() - 0.4); });
    EdgeCrossings found;
    EXPECT_EQ(crossEdges(cell.low, kStepX, kStepY, cell.edges, found), slope > 0.1);
  }
}

}  // namespace
}  // namespace argil::clay
