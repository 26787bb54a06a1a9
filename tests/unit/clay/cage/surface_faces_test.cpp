// Faces that creases part, on grids whose sides are known.

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "clay/base/error.h"
#include "clay/base/joined_sets.h"
#include "clay/mesh/surface_faces.h"

namespace argil::clay {
namespace {

// A torus of n × m quads, 1 mm by 2.5 mm in the mean: closed, and its cells have rows and columns.
struct Torus {
  int n, m;
  std::vector<Vec3d> positions;
  std::vector<std::array<uint32_t, 4>> quads;
  Torus(int rows, int columns) : n(rows), m(columns) {
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < m; ++j) {
        const double a = 2 * M_PI * i / n, b = 2 * M_PI * j / m, r = m / (2 * M_PI), big = n / (2 * M_PI) + 2 * r;
        positions.push_back(
            {(big + r * std::cos(b)) * std::cos(a), (big + r * std::cos(b)) * std::sin(a), r * std::sin(b)});
      }
    for (int i = 0; i < n; ++i)
      for (int j = 0; j < m; ++j) quads.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
  }
  [[nodiscard]] uint32_t at(int i, int j) const { return static_cast<uint32_t>((i + n) % n * m + (j + m) % m); }
  // Marks the sides between rows i − 1 and i, but for some columns.
  void bend(const SurfaceCells& cells, int i, int from, int to, std::vector<bool>& bent) const {
    for (int j = 0; j < m; ++j) {
      if (j >= from && j < to) continue;
      const uint32_t below = at(i - 1, j), above = at(i, j);
      for (size_t s = 0; s < 4; ++s) {
        if (cells.across[4 * below + s] == above) bent[4 * below + s] = true;
        if (cells.across[4 * above + s] == below) bent[4 * above + s] = true;
      }
    }
  }
};

size_t countOf(const std::vector<uint32_t>& face) {
  return std::set<uint32_t>(face.begin(), face.end()).size();
}

TEST(SurfaceFaces, LieBetweenClosedCreases) {
  const Torus torus(40, 30);
  const SurfaceCells cells(torus.positions, torus.quads);
  std::vector<bool> bent(4 * cells.count());
  EXPECT_EQ(countOf(facesOf(cells, bent, 1)), 1u);
  torus.bend(cells, 0, 0, 0, bent);
  EXPECT_EQ(countOf(facesOf(cells, bent, 1)), 1u) << "one ring does not part a torus";
  torus.bend(cells, 20, 0, 0, bent);
  const std::vector<uint32_t> face = facesOf(cells, bent, 1);
  EXPECT_EQ(countOf(face), 2u);
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 30; ++j) EXPECT_EQ(face[torus.at(i, j)] == face[torus.at(0, 0)], i < 20) << i << " " << j;
}

TEST(SurfaceFaces, StayTwoBesideAShortGapAndAreOneBesideALongOne) {
  const Torus torus(40, 30);
  const SurfaceCells cells(torus.positions, torus.quads);
  for (const int gap : {1, 2, 3, 20}) {
    std::vector<bool> bent(4 * cells.count());
    torus.bend(cells, 0, 0, 0, bent);
    torus.bend(cells, 20, 5, 5 + gap, bent);
    EXPECT_EQ(countOf(facesOf(cells, bent, 1)), gap < 20 ? 2u : 1u) << gap;
  }
}

TEST(SurfaceFaces, NarrowOnesGoToTheirNeighbour) {
  const Torus torus(40, 30);
  const SurfaceCells cells(torus.positions, torus.quads);
  std::vector<bool> bent(4 * cells.count());
  for (const int i : {0, 20, 23}) torus.bend(cells, i, 0, 0, bent);
  EXPECT_EQ(countOf(facesOf(cells, bent, 1)), 3u);
  EXPECT_EQ(countOf(facesOf(cells, bent, 9)), 2u) << "three rows are less than 9 mm wide";
}

TEST(SurfaceFaces, AreTidied) {
  const Torus torus(40, 30);
  const SurfaceCells cells(torus.positions, torus.quads);
  std::vector<uint32_t> face(cells.count());
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 30; ++j) face[torus.at(i, j)] = i < 20 ? 7 : 9;
  face[torus.at(20, 4)] = 7;            // a tooth
  face[torus.at(10, 10)] = 9;           // and an island
  face[torus.at(30, 10)] = UINT32_MAX;  // and what is not known
  tidyFaces(cells, face);
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 30; ++j) EXPECT_EQ(face[torus.at(i, j)] == face[torus.at(0, 0)], i < 20) << i << " " << j;
  // What is one number in two places becomes two faces.
  for (int i = 0; i < 40; ++i)
    for (int j = 0; j < 30; ++j) face[torus.at(i, j)] = i / 10 % 2 ? 7 : 9;
  tidyFaces(cells, face);
  EXPECT_EQ(countOf(face), 4u);
  std::vector<uint32_t> unknown(cells.count(), UINT32_MAX);
  tidyFaces(cells, unknown);
  EXPECT_EQ(countOf(unknown), 1u);
}

TEST(SurfaceFaces, RefuseWhatIsNotClosed) {
  Torus torus(12, 8);
  torus.quads.pop_back();
  EXPECT_THROW(SurfaceCells(torus.positions, torus.quads), Error);
  torus.quads.push_back(torus.quads.front());
  EXPECT_THROW(SurfaceCells(torus.positions, torus.quads), Error);
}

TEST(JoinedSets, TheLowestNamesASet) {
  JoinedSets sets(6);
  EXPECT_TRUE(sets.join(5, 3));
  EXPECT_TRUE(sets.join(3, 1));
  EXPECT_FALSE(sets.join(1, 5));
  EXPECT_TRUE(sets.join(2, 4));
  const uint32_t names[] = {0, 1, 2, 1, 2, 1};
  for (uint32_t i = 0; i < 6; ++i) EXPECT_EQ(sets.find(i), names[i]) << i;
}

}  // namespace
}  // namespace argil::clay
