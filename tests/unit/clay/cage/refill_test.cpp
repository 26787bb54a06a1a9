// Disks of quads that are filled anew with fewer vertices of other than four quads.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <map>
#include <random>
#include <set>
#include <thread>
#include <utility>

#include "clay/base/error.h"
#include "clay/cage/cage_maker.h"
#include "clay/cage/quad_patches.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

Grid grid(double voxelMm = 0.5) {
  Grid grid;
  grid.voxelMm = voxelMm;
  return grid;
}

/// A polygon on a circle with so many edges a side.
std::vector<BorderSide> polygon(const std::vector<int>& lengths) {
  std::vector<BorderSide> sides;
  uint32_t next = 0;
  for (const int length : lengths) {
    BorderSide side;
    for (int k = 0; k <= length; ++k) side.push_back(next + static_cast<uint32_t>(k));
    next += static_cast<uint32_t>(length);
    sides.push_back(side);
  }
  sides.back().back() = 0;
  return sides;
}

// Every border of two to six sides: what is filled is a disk of quads within it, with one at each corner, two along
// sides, four at all vertices but as many as are told, of which there are as few as the header says.
TEST(QuadFill, IsADiskWithFewIrregularVertices) {
  size_t fills = 0, refusals = 0;
  std::array<size_t, 3> byIrregular{};
  for (size_t n = 2; n <= 6; ++n) {
    std::vector<int> lengths(n, 1);
    std::mt19937 random(static_cast<unsigned>(n));
    for (int round = 0; round < 600; ++round) {
      for (int& each : lengths) each = 1 + int(random() % 7);
      const std::vector<BorderSide> sides = polygon(lengths);
      size_t border = 0;
      for (const int each : lengths) border += size_t(each);
      const auto at = [&](uint32_t v) {
        const double angle = 6.283185307179586 * v / double(border);
        return Vec3d(std::cos(angle), std::sin(angle), 0);
      };
      const QuadFill fill = filled(sides, 12, at);
      if (fill.quads.empty()) {
        ++refusals;
        // A vertex of three quads beside one of five makes both pairs of sides differ by one.
        const bool cut = n == 4 && std::abs(lengths[0] - lengths[2]) == 1 && std::abs(lengths[1] - lengths[3]) == 1;
        EXPECT_FALSE(cut && *std::min_element(lengths.begin(), lengths.end()) > 3);
        continue;
      }
      ++fills;
      ASSERT_EQ(border % 2, 0u);
      EXPECT_EQ(fill.irregular, leastIrregular(lengths));
      ++byIrregular[size_t(fill.irregular)];
      std::map<std::pair<uint32_t, uint32_t>, int> edges;
      std::map<uint32_t, int> around;
      for (const auto& quad : fill.quads)
        for (size_t s = 0; s < 4; ++s) {
          ++edges[{quad[s], quad[(s + 1) & 3]}];
          ++around[quad[s]];
        }
      size_t outer = 0;
      for (const auto& [edge, count] : edges) {
        EXPECT_EQ(count, 1);
        outer += !edges.contains({edge.second, edge.first});
      }
      EXPECT_EQ(outer, border);
      for (const BorderSide& side : sides)
        for (size_t k = 0; k + 1 < side.size(); ++k) {
          EXPECT_TRUE(edges.contains({side[k], side[k + 1]}));
          EXPECT_EQ(around[side[k]], k == 0 ? 1 : 2);
        }
      EXPECT_EQ(around.size(), border + fill.added.size());
      EXPECT_EQ(around.size() + fill.quads.size(), (edges.size() + outer) / 2 + 1);
      int irregular = 0;
      for (uint32_t k = 0; k < fill.added.size(); ++k) {
        irregular += around[QuadFill::kAdded + k] != 4;
        EXPECT_LE(fill.added[k].norm(), 1.001);
      }
      EXPECT_EQ(irregular, fill.irregular);
    }
  }
  EXPECT_GT(fills, 400u);
  EXPECT_GT(refusals, 400u);
  for (const size_t each : byIrregular) EXPECT_GT(each, 0u);
}

// Of the ways to cut the one with about so many quads is taken.
TEST(QuadFill, HasAboutAsManyQuadsAsAsked) {
  const auto at = [](uint32_t) { return Vec3d(Vec3d::Zero()); };
  const std::vector<BorderSide> sides = polygon({7, 7, 5, 5});
  const size_t few = filled(sides, 1, at).quads.size(), many = filled(sides, 60, at).quads.size();
  EXPECT_GT(few, 10u);
  EXPECT_GT(many, few + 5);
}

int unevenness(const QuadWeb& web) {
  int sum = 0;
  for (uint32_t v = 0; v < web.vertices(); ++v)
    if (const int n = static_cast<int>(web.around(v).size()); n > 0) sum += (n - 4) * (n - 4);
  return sum;
}

void replaceIn(QuadWeb& web, const Refill& refill) {
  std::vector<std::array<uint32_t, 4>> quads = refill.made;
  std::vector<uint32_t> added;
  for (const Vec3d& p : refill.added) added.push_back(web.add(p));
  for (auto& quad : quads)
    for (uint32_t& v : quad)
      if (v >= QuadFill::kAdded) v = added[v - QuadFill::kAdded];
  (void)web.replace(refill.quads, quads, refill.quads);
}

QuadMesh ringOf(uint32_t n, uint32_t m) {
  QuadMesh ring;
  for (uint32_t i = 0; i < n; ++i)
    for (uint32_t j = 0; j < m; ++j) {
      const double a = 6.283185307179586 * i / n, b = 6.283185307179586 * j / m;
      ring.positions.emplace_back((30 + 10 * std::cos(b)) * std::cos(a), (30 + 10 * std::cos(b)) * std::sin(a),
                                  10 * std::sin(b));
      const auto at = [&](uint32_t x, uint32_t y) { return (x % n) * m + y % m; };
      ring.quads.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return ring;
}

// A ring of quads has no irregular vertex. Edges that were turned at random make hundreds; refilled disks leave few,
// whatever order they come in, each gains what it says, and the mesh stays closed and a ring.
TEST(QuadPatches, TakeBackWhatWasTurned) {
  const QuadMesh ring = ringOf(36, 16);
  for (unsigned seed = 0; seed < 3; ++seed) {
    QuadWeb web(ring);
    std::mt19937 random(seed);
    for (int turns = 0; turns < 60;) {
      const auto f = static_cast<uint32_t>(random() % web.quads());
      const int corner = int(random() % 4);
      if (!web.gainOfTurn(f, corner, 1)) continue;
      web.turn(f, corner, 1);
      ++turns;
    }
    const int before = unevenness(web);
    EXPECT_GT(before, 80);
    QuadPatches patches(web);
    for (int round = 0, changed = 1; round < 8 && changed > 0; ++round) {
      changed = 0;
      for (uint32_t v = 0; v < web.vertices(); ++v) {
        if (web.around(v).empty()) continue;
        changed += patches.around(v, 150, [&](const Refill& refill) {
          const int was = unevenness(web);
          replaceIn(web, refill);
          EXPECT_EQ(was - unevenness(web), refill.gain);
          EXPECT_GT(refill.gain, 0);
          return true;
        });
      }
    }
    EXPECT_LE(unevenness(web), before / 5) << "of " << before;
    const QuadMesh mesh = web.mesh();
    const QuadTopology topology(mesh);  // throws where it is not closed
    EXPECT_EQ(mesh.positions.size(), mesh.quads.size());
  }
}

// No disk goes over a crease, and creases stay.
TEST(QuadPatches, LeaveCreases) {
  Surface surface(false, Grade::fine);
  surface.update(makeBlock(Store::make(), grid(5), Vec3d::Zero(), Vec3d(60, 40, 30), 0));
  QuadMesh block = quadsOf(surface);
  const QuadTopology topology(block.positions.size(), block.quads);
  block.creases.assign(block.quads.size(), 0);
  size_t creased = 0;
  const auto normal = [&](uint32_t f) {
    const auto& q = block.quads[f];
    return Vec3d((block.positions[q[2]] - block.positions[q[0]])
                     .cross(block.positions[q[3]] - block.positions[q[1]])
                     .normalized());
  };
  for (const auto& edge : topology.edges())
    if (normal(edge.quad[0]).dot(normal(edge.quad[1])) < 0.5) {
      ++creased;
      for (size_t k = 0; k < 2; ++k)
        block.creases[edge.quad[k]] = static_cast<uint8_t>(block.creases[edge.quad[k]] | 1 << edge.side[k]);
    }
  ASSERT_GT(creased, 50u);
  QuadWeb web(block);
  std::mt19937 random(1);
  for (int turns = 0; turns < 40;) {
    const auto f = static_cast<uint32_t>(random() % web.quads());
    const int corner = int(random() % 4);
    if (!web.gainOfTurn(f, corner, 1)) continue;
    web.turn(f, corner, 1);
    ++turns;
  }
  size_t taken = 0;
  QuadPatches patches(web);
  for (uint32_t v = 0; v < web.vertices(); ++v)
    if (!web.around(v).empty()) {
      taken += patches.around(v, 100, [&](const Refill& refill) {
        std::set<uint32_t> disk(refill.quads.begin(), refill.quads.end());
        for (const uint32_t f : refill.quads)
          for (size_t s = 0; s < 4; ++s)
            if ((web.creases(f) >> s & 1) != 0) {
              EXPECT_FALSE(disk.contains(web.across(web.quad(f)[(s + 1) & 3], web.quad(f)[s])));
            }
        replaceIn(web, refill);
        return true;
      });
    }
  EXPECT_GT(taken, 3u);
  const QuadMesh mesh = web.mesh();
  const QuadTopology after(mesh);
  size_t left = 0;
  for (const auto& edge : after.edges()) left += edge.crease;
  EXPECT_EQ(left, creased);
}

// Closed creases, which lie wholly within a disk that is large enough, and their corners, where one quad more or less
// leaves fewer than three.
TEST(QuadPatches, LeaveClosedCreasesAndThreeQuadsAtEachVertex) {
  const uint32_t n = 36, m = 16;
  size_t taken = 0;
  for (unsigned seed = 0; seed < 12; ++seed) {
    QuadMesh ring = ringOf(n, m);
    ring.creases.assign(ring.quads.size(), 0);
    const auto crease = [&](uint32_t i, uint32_t j, int side) {
      auto& bits = ring.creases[(i % n) * m + j % m];
      bits = static_cast<uint8_t>(bits | 1 << side);
    };
    // Around blocks of w × w quads. Side 0 of a quad goes along i.
    size_t creased = 0;
    for (uint32_t k = 0; k < 4; ++k) {
      const uint32_t i0 = 9 * k + 2, j0 = 3 + 2 * k, w = 1 + k % 3;
      for (uint32_t t = 0; t < w; ++t) {
        crease(i0 + t, j0, 0), crease(i0 + t, j0 + m - 1, 2);
        crease(i0 + t, j0 + w - 1, 2), crease(i0 + t, j0 + w, 0);
        crease(i0, j0 + t, 3), crease(i0 + n - 1, j0 + t, 1);
        crease(i0 + w - 1, j0 + t, 1), crease(i0 + w, j0 + t, 3);
        creased += 4;
      }
      for (const uint32_t i : {i0, i0 + w})
        for (const uint32_t j : {j0, j0 + w}) ring.corners.push_back((i % n) * m + j % m);
    }
    QuadWeb web(ring);
    std::mt19937 random(seed);
    for (int turns = 0; turns < 60;) {
      const auto f = static_cast<uint32_t>(random() % web.quads());
      const int corner = static_cast<int>(random() % 4), step = random() % 2 ? 1 : -1;
      if (!web.gainOfTurn(f, corner, step)) continue;
      web.turn(f, corner, step);
      ++turns;
    }
    QuadPatches patches(web);
    for (uint32_t v = 0; v < web.vertices(); ++v) {
      if (web.around(v).empty()) continue;
      taken += patches.around(v, 300, [&](const Refill& refill) {
        const std::set<uint32_t> disk(refill.quads.begin(), refill.quads.end());
        for (const uint32_t f : refill.quads)
          for (size_t s = 0; s < 4; ++s)
            if ((web.creases(f) >> s & 1) != 0) {
              EXPECT_FALSE(disk.contains(web.across(web.quad(f)[(s + 1) & 3], web.quad(f)[s])));
            }
        if (random() % 4 != 0) return false;  // larger ones as well
        replaceIn(web, refill);
        return true;
      });
    }
    for (uint32_t v = 0; v < web.vertices(); ++v)
      if (!web.around(v).empty()) {
        EXPECT_GE(web.around(v).size(), 3u);
      }
    const QuadTopology after(web.mesh());
    size_t left = 0;
    for (const auto& edge : after.edges()) left += edge.crease;
    EXPECT_EQ(left, creased);
  }
  EXPECT_GT(taken, 50u);
}

double farthest(const CageMaker& maker, const QuadMesh& cage) {
  TriangleMesh flat;
  flat.positions = cage.positions;
  for (const auto& q : cage.quads) {
    flat.triangles.push_back({q[0], q[1], q[2]});
    flat.triangles.push_back({q[0], q[2], q[3]});
  }
  const NearestTriangle tree(flat);
  double most = 0;
  for (const Vec3d& p : maker.surface().positions) most = std::max(most, std::sqrt(tree.nearest(p).squared));
  return most;
}

// A ball with knobs and a slit: a cage has few irregular vertices, and goes around and into all of it.
TEST(CoarseCage, HasFewIrregularVerticesAndLeavesNothingOut) {
  Version clay = makeSphere(Store::make(), grid(), Vec3d::Zero(), 20);
  for (const Vec3d& way : {Vec3d(1, 0, 0.3), Vec3d(-1, 0.4, 0), Vec3d(0, 1, 0.2), Vec3d(0.2, -1, -0.5)})
    clay = combine(clay, makeRod(Store::make(), grid(), 15 * way.normalized(), 27 * way.normalized(), 2.5),
                   Combination::join);
  clay = combine(clay, makeBlock(Store::make(), grid(), {0, 0, 20}, {2, 50, 24}, 0), Combination::cut);
  for (const size_t quads : {size_t{400}, size_t{1200}}) {
    const CageMaker maker(clay, quads, false, 2, WorkPart(nullptr));
    const CoarseCage cage = maker.make(WorkPart(nullptr));
    const QuadTopology topology(cage.mesh);
    EXPECT_EQ(cage.shape, 1);
    EXPECT_LT(topology.irregular(), cage.mesh.quads.size() / 8) << "of " << cage.mesh.quads.size();
    EXPECT_LT(farthest(maker, cage.mesh), 2.5) << quads;
  }
}

// Disks are looked for at the end, for seconds: that ends at once, too.
TEST(CoarseCage, CancelEndsTheSearchForDisks) {
  Version clay = makeSphere(Store::make(), grid(), Vec3d::Zero(), 20);
  clay = combine(clay, makeTorus(Store::make(), grid(), {0, 24, 0}, 12, 2.5), Combination::join);
  const CageMaker maker(clay, 800, false, 2, WorkPart(nullptr));
  Job job;
  std::atomic<bool> over{false};
  std::jthread watcher([&] {
    while (job.fraction() < 1 && !over) std::this_thread::yield();
    job.cancel();
  });
  EXPECT_THROW((void)maker.make(WorkPart(&job)), Cancelled);
  over = true;
}

// What was added in vain is as if it never had been.
TEST(QuadWeb, TakesVerticesBack) {
  QuadWeb web(ringOf(8, 6));
  EXPECT_EQ(web.add(Vec3d::Zero()), 48u);
  EXPECT_EQ(web.add(Vec3d::Zero()), 49u);
  web.takeBack(48);
  EXPECT_EQ(web.vertices(), 48u);
  EXPECT_EQ(web.add(Vec3d::UnitX()), 48u);
  EXPECT_TRUE(web.around(48).empty());
  EXPECT_EQ(web.mesh().positions.size(), 48u);
}

// Many handles need many quads, which is known before any is drawn.
TEST(CoarseCage, SaysHowManyItsHandlesNeed) {
  Version clay = makeBlock(Store::make(), grid(), Vec3d::Zero(), {60, 60, 4}, 0);
  for (int i = 0; i < 5; ++i)
    for (int j = 0; j < 5; ++j)
      clay = combine(clay, makeBlock(Store::make(), grid(), {11.0 * i - 22, 11.0 * j - 22, 0}, {6, 6, 10}, 0),
                     Combination::cut);
  try {
    (void)coarseCage(clay, 90, WorkPart(nullptr));
    ADD_FAILURE() << "no refusal";
  } catch (const Error& e) {
    EXPECT_STREQ(e.what(), "the piece has 25 handles: a cage needs at least 96 quads");
  }
  EXPECT_EQ(coarseCage(clay, 600, WorkPart(nullptr)).shape, -24);
}

}  // namespace
}  // namespace argil::clay
