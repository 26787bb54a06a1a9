#include "io/models/surface_points.h"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

Vec3d normalOf(const clay::TriangleMesh& mesh, size_t triangle) {
  const auto& [a, b, c] = mesh.triangles[triangle];
  return (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]).normalized();
}

Vec3d direction(const std::array<float, 3>& n) {
  return Vec3d(double(n[0]), double(n[1]), double(n[2]));
}

TEST(SurfacePoints, OfACubeAreThreeAtEachCorner) {
  ModelObject cube;
  cube.mesh = samples::cube(10);
  const SurfacePoints points = pointsOf(cube, Normals::creased);
  ASSERT_EQ(points.vertex.size(), 24u);
  ASSERT_EQ(points.normals.size(), 24u);
  for (size_t t = 0; t < 12; ++t) {
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t point = points.triangles[t][k];
      EXPECT_EQ(points.vertex[point], cube.mesh.triangles[t][k]);
      EXPECT_LT((direction(points.normals[point]) - normalOf(cube.mesh, t)).norm(), 1e-6);
    }
  }
}

TEST(SurfacePoints, OfABallAreItsVertices) {
  ModelObject ball;
  constexpr uint32_t kAround = 40, kUp = 24;
  ball.mesh.positions.emplace_back(0, 0, -7);
  for (uint32_t j = 1; j < kUp; ++j) {
    for (uint32_t i = 0; i < kAround; ++i) {
      const double a = 2 * M_PI * i / kAround, b = M_PI * j / kUp - M_PI / 2;
      ball.mesh.positions.emplace_back(7 * std::cos(a) * std::cos(b), 7 * std::sin(a) * std::cos(b), 7 * std::sin(b));
    }
  }
  ball.mesh.positions.emplace_back(0, 0, 7);
  const auto at = [&](uint32_t j, uint32_t i) {
    return j == 0 ? 0 : j == kUp ? uint32_t(ball.mesh.positions.size() - 1) : 1 + (j - 1) * kAround + i % kAround;
  };
  for (uint32_t j = 0; j < kUp; ++j) {
    for (uint32_t i = 0; i < kAround; ++i) {
      if (j + 1 < kUp) ball.mesh.triangles.push_back({at(j, i), at(j + 1, i + 1), at(j + 1, i)});
      if (j > 0) ball.mesh.triangles.push_back({at(j, i), at(j, i + 1), at(j + 1, i + 1)});
    }
  }
  const SurfacePoints points = pointsOf(ball, Normals::creased);
  EXPECT_TRUE(points.vertex.empty());
  EXPECT_TRUE(points.triangles.empty());
  ASSERT_EQ(points.normals.size(), ball.mesh.positions.size());
  for (size_t i = 0; i < points.normals.size(); ++i)
    EXPECT_GT(direction(points.normals[i]).dot(ball.mesh.positions[i].normalized()), 0.9999) << i;
}

// Two squares that meet at 20 degrees, their triangles with no vertex in common.
TEST(SurfacePoints, OfVerticesInOnePlaceHaveTheNormalsOfOneSurface) {
  ModelObject whole, loose;
  whole.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {-1, 0, -0.36}, {-1, 1, -0.36}};
  whole.mesh.triangles = {{0, 1, 2}, {0, 2, 3}, {4, 0, 3}, {4, 3, 5}};
  for (const auto& triangle : whole.mesh.triangles) {
    const auto first = uint32_t(loose.mesh.positions.size());
    for (const uint32_t v : triangle) {
      loose.mesh.positions.push_back(whole.mesh.positions[v]);
      loose.vertexColours.push_back({uint8_t(first), uint8_t(v), 0, 255});
    }
    loose.mesh.triangles.push_back({first, first + 1, first + 2});
  }
  const SurfacePoints wanted = pointsOf(whole, Normals::creased), points = pointsOf(loose, Normals::joined);
  ASSERT_TRUE(wanted.vertex.empty());
  ASSERT_EQ(points.normals.size(), 12u);
  for (size_t t = 0; t < 4; ++t)
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t point = points.triangles.empty() ? loose.mesh.triangles[t][k] : points.triangles[t][k];
      EXPECT_EQ(points.colours.at(point), loose.vertexColours[3 * t + k]);
      EXPECT_LT((direction(points.normals[point]) - direction(wanted.normals[whole.mesh.triangles[t][k]])).norm(),
                1e-6);
    }
  // Apart they are flat.
  const SurfacePoints flat = pointsOf(loose, Normals::creased);
  EXPECT_GT((direction(flat.normals[0]) - direction(wanted.normals[0])).norm(), 0.1);
}

TEST(SurfacePoints, AreNoMoreThanVerticesWithoutNormals) {
  ModelObject cube;
  cube.mesh = samples::cube(10);
  cube.vertexColours.resize(8, Colour{1, 2, 3, 255});
  const SurfacePoints points = pointsOf(cube, Normals::none);
  EXPECT_TRUE(points.vertex.empty());
  EXPECT_TRUE(points.normals.empty());
  EXPECT_EQ(points.colours, cube.vertexColours);
}

// A crease and a border of colours along different edges of the same vertex.
TEST(SurfacePoints, KeepColoursOfVerticesAndTriangles) {
  ModelObject cube;
  cube.mesh = samples::cube(10);
  for (uint8_t i = 0; i < 8; ++i) cube.vertexColours.push_back({i, 0, 0, 255});
  const SurfacePoints byVertex = pointsOf(cube, Normals::creased);
  ASSERT_EQ(byVertex.colours.size(), 24u);
  for (size_t i = 0; i < 24; ++i) EXPECT_EQ(byVertex.colours[i].red, byVertex.vertex[i]);
  for (size_t t = 0; t < 12; ++t) cube.triangleColours.push_back({uint8_t(t), 9, 9, 255});
  const SurfacePoints byTriangle = pointsOf(cube, Normals::creased);
  EXPECT_EQ(byTriangle.vertex.size(), 36u);
  for (size_t t = 0; t < 12; ++t) {
    for (size_t k = 0; k < 3; ++k) {
      const uint32_t point = byTriangle.triangles[t][k];
      EXPECT_EQ(byTriangle.colours[point], cube.triangleColours[t]);
      EXPECT_LT((direction(byTriangle.normals[point]) - normalOf(cube.mesh, t)).norm(), 1e-6);
    }
  }
}

// A disc whose triangles have two colours by turns: its middle has two points, not one for each border between them.
TEST(SurfacePoints, OfColoursThatComeAgainAreOneEach) {
  ModelObject disc;
  disc.mesh.positions.emplace_back(0, 0, 0);
  constexpr uint32_t kRim = 8;
  for (uint32_t i = 0; i < kRim; ++i)
    disc.mesh.positions.emplace_back(std::cos(2 * M_PI * i / kRim), std::sin(2 * M_PI * i / kRim), 0);
  for (uint32_t i = 0; i < kRim; ++i) {
    disc.mesh.triangles.push_back({0, 1 + i, 1 + (i + 1) % kRim});
    disc.triangleColours.push_back({uint8_t(i % 2), 0, 0, 255});
  }
  for (const Normals normals : {Normals::none, Normals::creased}) {
    const SurfacePoints points = pointsOf(disc, normals);
    EXPECT_EQ(points.vertex.size(), 2u + 2 * kRim);
    for (size_t t = 0; t < kRim; ++t)
      for (size_t k = 0; k < 3; ++k) {
        const uint32_t point = points.triangles[t][k];
        EXPECT_EQ(points.vertex.at(point), disc.mesh.triangles[t][k]);
        EXPECT_EQ(points.colours.at(point), disc.triangleColours[t]);
      }
  }
}

// A tip of a hundred thousand triangles, all of another colour, and some without area.
TEST(SurfacePoints, OfATipOfManyTrianglesAreQuick) {
  constexpr uint32_t kRim = 100000;
  ModelObject cone;
  cone.mesh.positions.emplace_back(0, 0, 1);
  for (uint32_t i = 0; i < kRim; ++i)
    cone.mesh.positions.emplace_back(10 * std::cos(2 * M_PI * i / kRim), 10 * std::sin(2 * M_PI * i / kRim), 0);
  for (uint32_t i = 0; i < kRim; ++i) {
    cone.mesh.triangles.push_back({0, 1 + i, 1 + (i + 1) % kRim});
    cone.triangleColours.push_back({uint8_t(i), uint8_t(i >> 8), uint8_t(i >> 16), 255});
  }
  cone.mesh.triangles.push_back({0, 1, 1});
  cone.triangleColours.push_back({});
  const SurfacePoints points = pointsOf(cone, Normals::creased);
  EXPECT_EQ(points.vertex.size(), 3u * kRim + 2);
  for (const auto& normal : points.normals) {
    ASSERT_NEAR(direction(normal).norm(), 1, 1e-5);
    ASSERT_GT(normal[2], 0.9f);
  }
}

}  // namespace
}  // namespace argil::io
