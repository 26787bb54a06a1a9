// Vertices at creases, eight cells at once: of faces that are known, alone and beside others, on all targets.

#include "clay/kernels/crisp_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <functional>
#include <initializer_list>
#include <memory>
#include <string>
#include <vector>

#include "clay/base/vec.h"
#include "clay/kernels/cell_cases.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

constexpr CrispRule kRule{.most = 0.02f, .blurred = 0.05f, .share = 0, .least = 1};
constexpr int kVoxels = kBlockCells + 1, kStepY = 16, kStepX = kVoxels * kStepY, kMargin = 2;

// A block of voxels with the planes of its crossed cells. Its middle is at 6.5 voxels, where the tests put creases.
struct Block {
  std::vector<float> phi = std::vector<float>(kVoxels * kStepX);
  std::vector<BlockCell> crossed;
  std::unique_ptr<BlockPlanes> planes = std::make_unique<BlockPlanes>();

  explicit Block(const std::function<float(const Vec3f&)>& field) {
    for (int x = 0; x < kVoxels; ++x)
      for (int y = 0; y < kVoxels; ++y)
        for (int z = 0; z < kVoxels; ++z)
          phi[size_t(x * kStepX + y * kStepY + z)] = field(Vec3f(float(x), float(y), float(z)));
    for (int x = 0; x < kBlockCells; ++x)
      for (int y = 0; y < kBlockCells; ++y)
        for (int z = 0; z < kBlockCells; ++z)
          if (pattern(x, y, z) % 255 != 0) crossed.push_back(BlockCell(x << 8 | y << 4 | z));
    std::vector<BlockCell> padded = crossed;
    padded.resize(crossed.size() + BlockPlanes::kPadding, crossed[0]);
    cellPlanes(phi.data(), kStepX, kStepY, kMargin, padded.data(), int(crossed.size()), *planes);
  }

  const float* at(int x, int y, int z) const { return &phi[size_t(x * kStepX + y * kStepY + z)]; }
  unsigned pattern(int x, int y, int z) const {
    unsigned inside = 0;
    for (int c = 0; c < 8; ++c) inside |= unsigned{*at(x + (c >> 2), y + (c >> 1 & 1), z + (c & 1)) < 0} << c;
    return inside;
  }
  // The crossed cells that have `around` cells on all sides.
  std::vector<BlockCell> inner(int around) const {
    std::vector<BlockCell> cells;
    for (const BlockCell cell : crossed) {
      const int at[3] = {cell >> 8, cell >> 4 & 15, cell & 15};
      if (std::all_of(at, at + 3, [around](int a) { return a >= around && a < kBlockCells - around; }))
        cells.push_back(cell);
    }
    return cells;
  }

  void add(CrispCells& cells, BlockCell cell, const CrispRule& rule) const {
    cells.stepX = kStepX, cells.stepY = kStepY;
    const size_t k = size_t(cells.count++);
    const int p[3] = {cell >> 8, cell >> 4 & 15, cell & 15};
    cells.phi[k] = at(p[0], p[1], p[2]);
    const CellCase& c = cellCases().separated[pattern(p[0], p[1], p[2])];
    cells.edges[k] = c.edges;
    cells.rule[k] = &rule;
    Vec3f mean = Vec3f::Zero();
    for (unsigned left = c.edges; left != 0; left &= left - 1) {
      const CellEdge edge = kCellEdges[size_t(std::countr_zero(left))];
      const auto value = [&](int n) { return *at(p[0] + (n >> 2), p[1] + (n >> 1 & 1), p[2] + (n & 1)); };
      Vec3f crossing(float(edge.from >> 2), float(edge.from >> 1 & 1), float(edge.from & 1));
      crossing[edge.axis] += value(edge.from) / (value(edge.from) - value(edge.to));
      mean += crossing / float(std::popcount(unsigned{c.edges}));
    }
    for (int axis = 0; axis < 3; ++axis) {
      cells.low[axis][k] = float(p[axis] - kMargin);
      cells.draft[axis][k] = mean[axis];
    }
    cells.planes[k] = 0;
    for (size_t i = 0; i < crossed.size(); ++i) {
      const int other[3] = {crossed[i] >> 8, crossed[i] >> 4 & 15, crossed[i] & 15};
      const int steps = std::abs(other[0] - p[0]) + std::abs(other[1] - p[1]) + std::abs(other[2] - p[2]);
      if (steps <= 3 &&
          std::max({std::abs(other[0] - p[0]), std::abs(other[1] - p[1]), std::abs(other[2] - p[2])}) <= 2)
        cells.plane[k][cells.planes[k]++] = uint16_t(i);
    }
  }
};

Vec3f vectorAt(const float (&rows)[3][kCrispCells], size_t k) {
  return {rows[0][k], rows[1][k], rows[2][k]};
}

// Calls look(result, lane, cell) for the cells of a block, eight at a time.
template <class Look>
void placeAll(const Block& block, const std::vector<BlockCell>& list, const Look& look) {
  for (size_t first = 0; first < list.size(); first += kCrispCells) {
    const size_t count = std::min<size_t>(kCrispCells, list.size() - first);
    CrispCells cells;
    for (size_t k = 0; k < count; ++k) block.add(cells, list[first + k], kRule);
    CrispVertices found;
    placeCrisply(cells, *block.planes, found);
    for (size_t k = 0; k < count; ++k) look(found, k, list[first + k]);
  }
}

const Vec3f kMiddle(6.4f, 6.3f, 6.45f);

// A wedge, convex or concave, turned anyhow: its vertices stand on its edge or on its faces, to rounding.
TEST(CrispKernels, VerticesOfFlatFacesAreOnThem) {
  const Vec3f a = Vec3f(0.9f, 0.3f, -0.2f).normalized(), b = Vec3f(-0.4f, 0.8f, 0.3f).normalized();
  for (const bool convex : {true, false}) {
    const Block block([&](const Vec3f& p) {
      const float da = a.dot(p - kMiddle), db = b.dot(p - kMiddle);
      return convex ? std::max(da, db) : std::min(da, db);
    });
    tests::forEachSimdTarget([&](const std::string& name) {
      int edges = 0, faces = 0;
      placeAll(block, block.inner(3), [&](const CrispVertices& found, size_t k, BlockCell cell) {
        const unsigned bit = 1u << k;
        const Vec3f low(float(cell >> 8), float(cell >> 4 & 15), float(cell & 15)),
            p = vectorAt(found.position, k) + low - kMiddle;
        const Vec3f normal = vectorAt(found.normal, k).normalized();
        EXPECT_EQ(found.edge & found.face, 0u);
        EXPECT_EQ(found.curved & bit, 0u);
        if (found.edge & bit) {
          ++edges;
          EXPECT_LT(std::max(std::abs(a.dot(p)), std::abs(b.dot(p))), 1e-3f) << name;
          EXPECT_GT(normal.dot((a + b).normalized()), 0.999f);
          EXPECT_TRUE(found.explained & bit);
        } else if (found.face & bit) {
          ++faces;
          EXPECT_LT(std::min(std::abs(a.dot(p)), std::abs(b.dot(p))), 1e-3f) << name;
          EXPECT_GT(std::max(normal.dot(a), normal.dot(b)), 0.9999f);
        }
        EXPECT_EQ(found.third & bit, 0u);
      });
      EXPECT_GE(edges, 8) << name;
      EXPECT_GE(faces, 8) << name;
    });
  }
}

// Two balls of thirty voxels: by their tangent planes alone the circle would be 0.02 voxel and more away.
TEST(CrispKernels, CurvedFacesAreFollowed) {
  const Vec3f from = kMiddle + Vec3f(-29, 14, 3), other = kMiddle + Vec3f(16, 27, -4);
  const float r0 = (from - kMiddle).norm(), r1 = (other - kMiddle).norm();
  const Block block([&](const Vec3f& p) { return std::max((p - from).norm() - r0, (p - other).norm() - r1); });
  int edges = 0;
  float most = 0;
  placeAll(block, block.inner(3), [&](const CrispVertices& found, size_t k, BlockCell cell) {
    if (!(found.edge >> k & 1)) return;
    ++edges;
    const Vec3f low(float(cell >> 8), float(cell >> 4 & 15), float(cell & 15)), p = vectorAt(found.position, k) + low;
    most = std::max({most, std::abs((p - from).norm() - r0), std::abs((p - other).norm() - r1)});
  });
  EXPECT_GE(edges, 8);
  EXPECT_LT(most, 0.01f);
}

TEST(CrispKernels, SmoothFacesAndRoundingsHaveNoCrease) {
  const Vec3f ball = kMiddle + Vec3f(-9, 4, 3);
  const float r = (ball - kMiddle).norm();
  for (const auto& field : std::vector<std::function<float(const Vec3f&)>>{
           [](const Vec3f& p) { return Vec3f(0.6f, 0.7f, 0.387f).dot(p - kMiddle); },
           [&](const Vec3f& p) { return (p - ball).norm() - r; },
           // An edge of three voxels' radius.
           [](const Vec3f& p) { return std::hypot(std::max(p.x() - 3.4f, 0.0f), std::max(p.y() - 3.3f, 0.0f)) - 3; }}) {
    const Block block(field);
    placeAll(block, block.inner(3), [&](const CrispVertices& found, size_t k, BlockCell) {
      EXPECT_FALSE((found.edge | found.kinked) >> k & 1);
    });
  }
}

// A corner of three faces, anywhere in its cell.
TEST(CrispKernels, AThirdFaceIsTold) {
  int third = 0;
  for (float x = 0.05f; x < 1; x += 0.1f)
    for (float y = 0.05f; y < 1; y += 0.1f) {
      const Vec3f corner(6 + x, 6 + y, 6.45f);
      const Block block([&](const Vec3f& p) {
        float most = -1e9f;
        for (int axis = 0; axis < 3; ++axis)
          most = std::max(most, (Vec3f::Unit(axis) + Vec3f::Constant(0.2f)).normalized().dot(p - corner));
        return most;
      });
      placeAll(block, block.inner(3), [&](const CrispVertices& found, size_t k, BlockCell cell) {
        if (!(found.third >> k & 1)) return;
        ++third;
        const Vec3f middle = Vec3f(float(cell >> 8), float(cell >> 4 & 15), float(cell & 15)) + Vec3f::Constant(0.5f);
        EXPECT_LT((middle - corner).norm(), 2.5f);
      });
    }
  EXPECT_GE(third, 10);
}

// Rules: planes that bend more than one asks for count for nothing, and one that asks for more planes finds nothing.
TEST(CrispKernels, RulesSayWhichPlanesCount) {
  EXPECT_EQ(planeQuality(0, 0, kRule), 1);
  EXPECT_EQ(planeQuality(kRule.most * kRule.most, 0, kRule), 0);
  EXPECT_EQ(planeQuality(kNoPlane, 0, kRule), 0);
  EXPECT_NEAR(planeQuality(0, 0.004f, kRule), 0.5f, 1e-3f);
  const Vec3f a = Vec3f(0.9f, 0.3f, -0.2f).normalized(), b = Vec3f(-0.4f, 0.8f, 0.3f).normalized();
  const Block block([&](const Vec3f& p) { return std::max(a.dot(p - kMiddle), b.dot(p - kMiddle)); });
  std::vector<BlockCell> edge;
  placeAll(block, block.inner(3), [&](const CrispVertices& found, size_t k, BlockCell cell) {
    if (found.edge >> k & 1) edge.push_back(cell);
  });
  ASSERT_FALSE(edge.empty());
  CrispRule many = kRule, flat = kRule, most = kRule;
  many.least = 40;
  flat.most = 1e-12f;
  most.share = 1.01f;
  CrispCells cells;
  for (const CrispRule* rule : std::initializer_list<const CrispRule*>{&many, &flat, &most, &kRule})
    block.add(cells, edge[0], *rule);
  CrispVertices found;
  placeCrisply(cells, *block.planes, found);
  EXPECT_EQ(found.edge | found.face, 0b1000u);
}

// A cell's vertex does not depend on the cells beside it, nor on the target: to the bit.
TEST(CrispKernels, EqualBitsWhateverStandsBeside) {
  const Vec3f from = kMiddle + Vec3f(-9, 4, 3), other = kMiddle + Vec3f(6, 7, -4);
  const float r0 = (from - kMiddle).norm(), r1 = (other - kMiddle).norm();
  const Block block([&](const Vec3f& p) {
    return std::max({(p - from).norm() - r0, (p - other).norm() - r1, p.z() - kMiddle.z() - 1.2f});
  });
  const std::vector<BlockCell> list = block.inner(2);
  using Result = std::array<uint32_t, 7>;
  const auto resultOf = [](const CrispVertices& found, size_t k) {
    Result r{};
    for (const unsigned bits : {found.kinked, found.edge, found.face, found.third, found.curved})
      r[0] = r[0] << 1 | (bits >> k & 1);
    if ((found.edge | found.face) >> k & 1) {
      r[0] = r[0] << 1 | (found.explained >> k & 1);
      for (size_t axis = 0; axis < 3; ++axis) {
        r[1 + axis] = std::bit_cast<uint32_t>(found.position[axis][k]);
        r[4 + axis] = std::bit_cast<uint32_t>(found.normal[axis][k]);
      }
    }
    return r;
  };
  std::vector<Result> first;
  tests::forEachSimdTarget([&](const std::string& name) {
    std::vector<Result> together, alone;
    placeAll(block, list, [&](const CrispVertices& found, size_t k, BlockCell) {
      together.push_back(resultOf(found, k));
      EXPECT_EQ((found.kinked | found.edge | found.face | found.third | found.curved | found.explained) >> kCrispCells,
                0u);
    });
    for (const BlockCell cell : list) {
      CrispCells cells;
      block.add(cells, cell, kRule);
      CrispVertices found;
      placeCrisply(cells, *block.planes, found);
      alone.push_back(resultOf(found, 0));
      EXPECT_LE(found.kinked | found.edge | found.face | found.third | found.curved | found.explained, 1u);
    }
    EXPECT_EQ(together, alone) << name;
    if (first.empty()) first = together;
    EXPECT_EQ(together, first) << name;
  });
  EXPECT_GT(std::count_if(first.begin(), first.end(), [](const Result& r) { return r[1] != 0; }), 12);
}

}  // namespace
}  // namespace argil::clay
