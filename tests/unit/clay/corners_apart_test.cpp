#include <gtest/gtest.h>

#include "clay/mesh/corners_apart.h"

namespace argil::clay {
namespace {

/// Triangles of which two corners are one 32-bit place, as the numbers are and about a middle in metres.
size_t coinciding(const TriangleMesh& mesh) {
  Vec3d low = mesh.positions[0], high = low;
  for (const Vec3d& p : mesh.positions) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const Vec3d middle = (low + high) / 2;
  size_t count = 0;
  for (const auto& t : mesh.triangles) {
    bool plain = false, metres = false;
    for (size_t k = 0; k < 3; ++k) {
      const Vec3d &a = mesh.positions[t[k]], &b = mesh.positions[t[(k + 1) % 3]];
      plain = plain || a.cast<float>() == b.cast<float>();
      metres = metres || ((a - middle) / 1000).cast<float>() == ((b - middle) / 1000).cast<float>();
    }
    count += plain || metres;
  }
  return count;
}

/// A grid of squares whose every third column lies on the one before, and some single vertices on their neighbours.
TriangleMesh collapsed(const Vec3d& at, double edge) {
  TriangleMesh mesh;
  constexpr uint32_t kSide = 30;
  for (uint32_t y = 0; y < kSide; ++y)
    for (uint32_t x = 0; x < kSide; ++x)
      mesh.positions.push_back(at + edge * Vec3d(x - (x % 3 == 2 ? 1.0 : 0.0), y - (x * y % 7 == 3 ? 1.0 : 0.0), 0));
  for (uint32_t y = 1; y < kSide; ++y) {
    for (uint32_t x = 1; x < kSide; ++x) {
      const uint32_t v = y * kSide + x;
      mesh.triangles.push_back({v - kSide - 1, v - kSide, v});
      mesh.triangles.push_back({v - kSide - 1, v, v - 1});
    }
  }
  return mesh;
}

TEST(CornersApart, NoTriangleHasTwoCornersInOnePlace) {
  for (const double edge : {0.2, 1e-3, 50.0}) {
    for (const Vec3d& at : {Vec3d(0, 0, 0), Vec3d(-3, 700, 0.1), Vec3d(1e4, 1e4, 1e4)}) {
      const TriangleMesh before = collapsed(at, edge);
      TriangleMesh mesh = before;
      ASSERT_GT(coinciding(mesh), 100u);
      const size_t moved = moveCornersApart(mesh);
      EXPECT_GT(moved, 0u);
      EXPECT_EQ(coinciding(mesh), 0u);
      EXPECT_EQ(mesh.triangles, before.triangles);
      double largest = 0, farthest = 0;
      for (size_t i = 0; i < mesh.positions.size(); ++i) {
        largest = std::max(largest, before.positions[i].cwiseAbs().maxCoeff());
        farthest = std::max(farthest, (mesh.positions[i] - before.positions[i]).norm());
      }
      EXPECT_LT(farthest, 1e-5 * largest);
    }
  }
}

TEST(CornersApart, OtherVerticesStayWhereTheyAre) {
  TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 1, 0}, {1, 1, 0}}, {{0, 1, 2}, {1, 3, 2}, {3, 4, 2}}};
  const TriangleMesh before = mesh;
  EXPECT_EQ(moveCornersApart(mesh), 1u);
  for (size_t i = 0; i < 4; ++i) EXPECT_EQ(mesh.positions[i], before.positions[i]);
  EXPECT_NE(mesh.positions[4], before.positions[4]);
  // Vertices in one place that no triangle joins are meant: bodies that touch.
  TriangleMesh touching{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {0, 0, 0}, {-1, 0, 0}, {0, -1, 0}}, {{0, 1, 2}, {3, 4, 5}}};
  EXPECT_EQ(moveCornersApart(touching), 0u);
  // A vertex that is named twice cannot be moved from itself.
  TriangleMesh twice{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}, {{0, 1, 2}, {1, 1, 2}}};
  EXPECT_EQ(moveCornersApart(twice), 0u);
}

TEST(CornersApart, TrianglesWithOnePlaceTwiceAreMarked) {
  const TriangleMesh mesh{{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {1, 0, 1e-9}, {2, 0, 0}},
                          {{0, 1, 2}, {1, 3, 2}, {1, 1, 2}, {0, 2, 0}, {0, 1, 4}}};
  EXPECT_EQ(haveOnePlaceTwice(mesh), (std::vector<bool>{false, true, true, true, false}))
      << "a triangle without area whose corners differ is another matter";
}

TEST(CornersApart, PiecesGiveWhatTheWholeGives) {
  TriangleMesh mesh = collapsed({5, 6, 7}, 0.1);
  constexpr uint32_t kRow = 30;
  const auto pieces = [&](const MeshPiece& visit) {
    size_t triangle = 0;
    for (uint32_t row = 0; row < kRow; ++row) {
      const size_t end = row == 0 ? 0 : triangle + 2 * (kRow - 1);
      visit(row * kRow, std::span(mesh.positions).subspan(row * kRow, kRow),
            std::span(mesh.triangles).subspan(triangle, end - triangle));
      triangle = end;
    }
  };
  TriangleMesh inPieces = mesh;
  for (const auto& [vertex, place] : cornersApart(pieces)) inPieces.positions[vertex] = place;
  moveCornersApart(mesh);
  EXPECT_EQ(inPieces.positions, mesh.positions);
}

}  // namespace
}  // namespace argil::clay
