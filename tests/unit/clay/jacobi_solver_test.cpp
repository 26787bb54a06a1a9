// Bricks solved together, pass by pass, against the same passes over a dense field.

#include "clay/field/jacobi_solver.h"

#include <gtest/gtest.h>

#include <bit>
#include <map>
#include <random>
#include <vector>

namespace argil::clay {
namespace {

// Of whole numbers, so that sums are exact: the least of a voxel's own value and those up to `layers` voxels along an
// axis, each plus what it costs to come from there.
template <int layers>
float next(const float* around, int at) {
  using Solver = JacobiSolver<layers>;
  float least = around[at];
  for (const int step : {Solver::offset(1, 0, 0), Solver::offset(0, 1, 0), Solver::offset(0, 0, 1)})
    for (int k = 1; k <= layers; ++k)
      for (const int side : {-1, 1}) least = std::min(least, around[at + side * k * step] + float(k * k + step % 3));
  return least;
}

// 3×2×2 bricks less one, with frozen voxels and rows, and nothing known but a few voxels.
template <int layers>
void passesAreThoseOfADenseField(int passes) {
  using Solver = JacobiSolver<layers>;
  constexpr float kUnknown = 1e6f, kOutside = 500;
  std::mt19937_64 random(7);
  std::vector<Coord> coords;
  for (int x = 0; x < 3; ++x)
    for (int y = 0; y < 2; ++y)
      for (int z = 0; z < 2; ++z)
        if (!(x == 1 && y == 1 && z == 0)) coords.push_back({x, y, z});
  // The dense field, with what lies around the bricks.
  constexpr int kLow = -layers;
  const Coord size{24 + 2 * layers, 16 + 2 * layers, 16 + 2 * layers};
  const auto place = [&](Coord v) { return size_t(((v.x - kLow) * size.y + v.y - kLow) * size.z + v.z - kLow); };
  std::vector<float> dense(size_t(size.x * size.y * size.z), kOutside);
  std::map<Coord, std::array<uint64_t, kBrickEdge>> frozen;
  for (const Coord c : coords) {
    auto& bits = frozen[c];
    bits.fill(0);
    for (int i = 0; i < kBrickVoxels; ++i) {
      const uint64_t draw = random();
      dense[place(c * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7})] = draw % 200 == 0 ? float(draw % 17) : kUnknown;
      // rows that are frozen whole too
      if (draw % 29 == 0 || (i >> 3) % 13 == 5) bits[size_t(i >> 6)] |= uint64_t{1} << (i & 63);
    }
  }
  const auto isFrozen = [&](Coord v) {
    const auto found = frozen.find(v >> kBrickBits);
    return found == frozen.end() || ((found->second[size_t(v.x & 7)] >> ((v.y & 7) * 8 + (v.z & 7))) & 1) != 0;
  };
  const auto around = [&](Coord c, float* out) {
    for (int x = kLow; x < 8 + layers; ++x)
      for (int y = kLow; y < 8 + layers; ++y)
        for (int z = kLow; z < 8 + layers; ++z)
          out[Solver::offset(x + layers, y + layers, z + layers)] = dense[place(c * kBrickEdge + Coord{x, y, z})];
  };

  Solver solver(coords, 1);
  for (size_t i = 0; i < coords.size(); ++i) {
    float room[Solver::kAroundSize];
    around(coords[i], room);
    uint64_t bits[kBrickEdge];
    std::copy_n(frozen[coords[i]].begin(), kBrickEdge, bits);
    solver.begin(i, room, bits);
  }
  int64_t rowsComputed = 0, bricksComputed = 0;
  solver.run(passes, [&](const float* from, const uint64_t* bits, uint64_t rows, float* out) {
    uint64_t changed = 0;
    rowsComputed += std::popcount(rows);
    ++bricksComputed;
    for (; rows != 0; rows &= rows - 1) {
      const int row = std::countr_zero(rows);
      for (int i = row * 8; i < row * 8 + 8; ++i) {
        const int at = Solver::offset((i >> 6) + layers, ((i >> 3) & 7) + layers, (i & 7) + layers);
        out[i] = ((bits[i >> 6] >> (i & 63)) & 1) ? from[at] : next<layers>(from, at);
        changed |= uint64_t{out[i] != from[at]} << row;
      }
    }
    return changed;
  });

  for (int pass = 0; pass < passes; ++pass) {
    const std::vector<float> before = dense;
    for (const Coord c : coords) {
      float room[Solver::kAroundSize];
      for (int x = kLow; x < 8 + layers; ++x)
        for (int y = kLow; y < 8 + layers; ++y)
          for (int z = kLow; z < 8 + layers; ++z)
            room[Solver::offset(x + layers, y + layers, z + layers)] = before[place(c * kBrickEdge + Coord{x, y, z})];
      for (int i = 0; i < kBrickVoxels; ++i) {
        const Coord v = c * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
        if (!isFrozen(v))
          dense[place(v)] =
              next<layers>(room, Solver::offset((i >> 6) + layers, ((i >> 3) & 7) + layers, (i & 7) + layers));
      }
    }
  }
  for (size_t b = 0; b < coords.size(); ++b)
    for (int i = 0; i < kBrickVoxels; ++i) {
      const Coord v = coords[b] * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
      ASSERT_EQ(solver.values(b)[i], dense[place(v)]) << v.x << " " << v.y << " " << v.z << ", " << passes << " passes";
    }
  EXPECT_LE(rowsComputed, (passes > 20 ? 50 : 64) * bricksComputed) << "rows rest";
}

TEST(JacobiSolver, RowsThatRestChangeNothing) {
  for (const int passes : {1, 2, 3, 5, 8, 40}) {
    ASSERT_NO_FATAL_FAILURE(passesAreThoseOfADenseField<1>(passes));
    ASSERT_NO_FATAL_FAILURE(passesAreThoseOfADenseField<2>(passes));
  }
}

// What is said to be solved already is computed once something beside it changes, and not before.
TEST(JacobiSolver, RowsThatAreSolvedAreNotComputedAgain) {
  const std::vector<Coord> coords{{0, 0, 0}, {1, 0, 0}};
  JacobiSolver<1> solver(coords, 1);
  const uint64_t frozen[kBrickEdge] = {};
  std::vector<float> around(JacobiSolver<1>::kAroundSize, 3);
  solver.begin(0, around.data(), frozen, 0);
  solver.begin(1, around.data(), frozen, uint64_t{1} << 2);  // x = 0, y = 2: beside the other brick
  std::vector<uint64_t> asked;
  solver.run(3, [&](const float* from, const uint64_t*, uint64_t rows, float* out) {
    asked.push_back(rows);
    for (uint64_t left = rows; left != 0; left &= left - 1) {
      const int row = std::countr_zero(left);
      for (int z = 0; z < 8; ++z)
        out[row * 8 + z] = from[JacobiSolver<1>::offset((row >> 3) + 1, (row & 7) + 1, z + 1)] - 1;
    }
    return asked.size() == 1 ? rows : 0;
  });
  // Then the row, those beside it along y and x, and the one across the face.
  ASSERT_EQ(asked.size(), 3u);
  EXPECT_EQ(asked[0], uint64_t{1} << 2);
  EXPECT_EQ(asked[1], uint64_t{1} << (7 * 8 + 2));
  EXPECT_EQ(asked[2], uint64_t{0b1110} | uint64_t{1} << (8 + 2));
}

}  // namespace
}  // namespace argil::clay
