// Quads that are alone on a side of a line of creases: their corner there would be half a turn.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <set>

#include "clay/cage/cage_maker.h"
#include "clay/cage/quad_patches.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

Grid grid(double voxelMm) {
  Grid grid;
  grid.voxelMm = voxelMm;
  return grid;
}
QuadMesh ring() {
  Surface surface(false);
  surface.update(makeTorus(Store::make(), grid(3), Vec3d::Zero(), 14, 6));
  return quadsOf(surface);
}

// Sides become creases, on both quads that have them.
void markSides(QuadMesh& mesh, uint32_t from, uint32_t to) {
  mesh.creases.resize(mesh.quads.size(), 0);
  for (size_t f = 0; f < mesh.quads.size(); ++f)
    for (size_t s = 0; s < 4; ++s) {
      const uint32_t a = mesh.quads[f][s], b = mesh.quads[f][(s + 1) & 3];
      if ((a == from && b == to) || (a == to && b == from))
        mesh.creases[f] = static_cast<uint8_t>(mesh.creases[f] | 1 << s);
    }
}
size_t creasesOf(const QuadMesh& mesh) {
  size_t count = 0;
  for (const uint8_t bits : mesh.creases)
    for (int s = 0; s < 4; ++s) count += bits >> s & 1;
  return count / 2;
}
size_t creasesAt(const QuadWeb& web, uint32_t v) {
  std::vector<uint32_t> along;
  web.alongCreases(v, along);
  return along.size();
}

// Σ (n − 4)² as QuadWeb counts it where lines lose no more edges.
int unevenness(const QuadWeb& web) {
  int sum = 0;
  std::vector<uint32_t> sector;
  for (uint32_t v = 0; v < web.vertices(); ++v) {
    std::set<uint32_t> seen;
    for (const uint32_t f : web.around(v)) {
      if (!seen.insert(f).second) continue;
      sum += web.sectorOf(v, f, &sector).uneven(0, true);
      seen.insert(sector.begin(), sector.end());
    }
  }
  return sum;
}

// Within a line around two quads: what is told is a disk in their place, with two quads at the vertex, and as much gain
// as is told. The way that leads across the line is forbidden.
TEST(QuadPatches, GiveAQuadThatIsAloneASecondOne) {
  const QuadMesh mesh = ring();
  std::mt19937 random(1);
  for (int i = 0; i < 400; ++i) {
    QuadMesh creased = mesh;
    const auto f = static_cast<uint32_t>(random() % mesh.quads.size());
    const int corner = int(random() % 4);
    const auto at = [&](int s) { return mesh.quads[f][static_cast<size_t>(corner + s) & 3]; };
    const bool forward = random() % 2 == 0;
    const uint32_t from = at(forward ? 1 : 2), to = at(forward ? 2 : 3);
    const uint32_t other = QuadWeb(mesh).across(to, from);
    for (const uint32_t quad : {f, other})
      for (size_t s = 0; s < 4; ++s) {
        const uint32_t a = mesh.quads[quad][s], b = mesh.quads[quad][(s + 1) & 3];
        if (std::set{a, b} != std::set{from, to}) markSides(creased, a, b);
      }
    QuadWeb web(creased);
    const int before = unevenness(web);
    EXPECT_FALSE(QuadPatches(web).notAlone(f, corner, !forward));
    const std::optional<Refill> refill = QuadPatches(web).notAlone(f, corner, forward);
    ASSERT_TRUE(refill.has_value());
    const auto first = static_cast<uint32_t>(web.vertices());
    for (const Vec3d& p : refill->added) (void)web.add(p);
    std::vector<std::array<uint32_t, 4>> quads = refill->made;
    for (auto& quad : quads)
      for (uint32_t& v : quad)
        if (v >= QuadFill::kAdded) v = v - QuadFill::kAdded + first;
    const std::vector<uint32_t> made = web.replace(refill->quads, quads, refill->quads);
    EXPECT_EQ(web.count(), mesh.quads.size() + 2);
    const QuadMesh after = web.mesh();
    EXPECT_NO_THROW(QuadTopology(after.positions.size(), after.quads));
    EXPECT_EQ(after.positions.size(), after.quads.size()) << "a ring";
    EXPECT_EQ(creasesOf(after), 6u);
    const auto own = std::find_if(made.begin(), made.end(), [&](uint32_t each) {
      return std::ranges::find(web.quad(each), at(0)) != web.quad(each).end();
    });
    ASSERT_NE(own, made.end());
    EXPECT_EQ(web.sectorOf(at(0), *own).count, 2);
    EXPECT_EQ(before - unevenness(web), refill->gain);
  }
}

TEST(QuadPatches, GiveNoSecondQuadWhereThereAreTwo) {
  QuadMesh mesh = ring();
  // Straight on through a vertex of four.
  const QuadWeb plain(mesh);
  uint32_t v = 0;
  while (plain.around(v).size() != 4) ++v;
  const auto lines = plain.linesThrough(v);
  for (const uint32_t end : lines[0]) markSides(mesh, v, end);
  const QuadWeb web(mesh);
  for (const uint32_t f : web.around(v))
    for (int corner = 0; corner < 4; ++corner) EXPECT_FALSE(QuadPatches(web).notAlone(f, corner, true));
}

// No line of what is around it comes to an end.
TEST(QuadWeb, AFaceOfOneQuadJoinsTheOneThatItTurnsToLess) {
  const QuadMesh mesh = ring();
  std::mt19937 random(2);
  int all = 0, one = 0, refused = 0;
  for (int i = 0; i < 400; ++i) {
    QuadMesh creased = mesh;
    const auto f = static_cast<uint32_t>(random() % mesh.quads.size());
    const int corner = int(random() % 4);
    const auto at = [&](int s) { return mesh.quads[f][static_cast<size_t>(corner + s) & 3]; };
    for (int s = 0; s < 4; ++s) markSides(creased, at(s), at(s + 1));
    // Lines that go on from some of its corners, around which there are enough edges.
    std::set<int> more;
    const QuadWeb plain(mesh);
    for (int s = 0; s < 4; ++s) {
      if (random() % 2 == 0) continue;
      std::vector<uint32_t> beside;
      plain.beside(at(s), beside);
      std::erase_if(beside, [&](uint32_t v) { return std::ranges::find(mesh.quads[f], v) != mesh.quads[f].end(); });
      if (beside.empty()) continue;
      markSides(creased, at(s), beside.front());
      more.insert(s);
    }
    // Its corner comes out of the surface, so that the two sides there turn more.
    const Vec3d &p = creased.positions[at(0)], a = creased.positions[at(1)] - p, b = creased.positions[at(3)] - p;
    creased.positions[at(0)] += 3 * a.cross(b).normalized();
    QuadWeb web(creased);
    std::vector<size_t> before;
    for (uint32_t v = 0; v < web.vertices(); ++v) before.push_back(creasesAt(web, v));
    const size_t creases = creasesOf(creased);
    if (!web.joinFace(f, corner)) {
      ++refused;
      EXPECT_EQ(creasesOf(web.mesh()), creases);
      EXPECT_FALSE(more.empty());
      continue;
    }
    for (uint32_t v = 0; v < web.vertices(); ++v) EXPECT_FALSE(creasesAt(web, v) == 1 && before[v] > 1);
    if (more.empty()) {
      EXPECT_EQ(web.creases(f), 0);
      ++all;
    } else {
      EXPECT_EQ(creasesOf(web.mesh()), creases - 2);
      const bool opposite = creasesAt(web, at(2)) == 0;
      EXPECT_NE(opposite, creasesAt(web, at(0)) == 0);
      if (!more.contains(2)) {
        EXPECT_TRUE(opposite) << "there it turns less";
      }
      ++one;
    }
  }
  EXPECT_GT(all, 10);
  EXPECT_GT(one, 20);
  EXPECT_GT(refused, 40);
  QuadWeb web(mesh);
  EXPECT_FALSE(web.joinFace(0, 0)) << "its sides are no creases";
}

// Before, one to three quads of each of these but the last had a corner of half a turn, and edges were down to 0.01 of
// the mean, where vertices had gone for better corners.
TEST(CoarseCage, HasNeitherHalfTurnsNorTinyEdges) {
  struct Case {
    bool bored;
    size_t most;
    double voxelMm;
  };
  const Vec3d middle(1, 2, 3);
  for (const auto& [bored, most, voxelMm] : {Case{false, 100, 0.5},
                                             {false, 300, 0.5},
                                             {true, 63, 0.5},
                                             {true, 98, 0.5},
                                             {true, 200, 0.5},
                                             {true, 300, 0.5},
                                             {true, 60, 0.5},
                                             {false, 60, 0.4}}) {
    const Vec3d size = bored ? Vec3d(60, 40, 30) : Vec3d(40, 30, 20);
    Version clay = makeBlock(Store::make(), grid(voxelMm), middle, size, 0);
    if (bored) clay = combine(clay, makeCylinder(Store::make(), grid(voxelMm), middle, 12, 60), Combination::cut);
    const QuadMesh mesh = CageMaker(clay, most, true, 2, WorkPart(nullptr)).make(WorkPart(nullptr)).mesh;
    EXPECT_LE(mesh.quads.size(), most);
    EXPECT_GE(double(mesh.quads.size()), 0.9 * double(most));
    double shortest = INFINITY, mean = 0;
    for (const auto& quad : mesh.quads) {
      EXPECT_GT(scaledJacobian(mesh, quad), 0.2) << most;
      for (size_t s = 0; s < 4; ++s) {
        const double length = (mesh.positions[quad[s]] - mesh.positions[quad[(s + 1) & 3]]).norm();
        shortest = std::min(shortest, length);
        mean += length / (4 * double(mesh.quads.size()));
      }
    }
    EXPECT_GT(shortest, 0.03 * mean) << most;
  }
}

}  // namespace
}  // namespace argil::clay
