// Disks on both sides of a line of creases that change the line's count of edges, and where what fills a disk lies.

#include <gtest/gtest.h>

#include <algorithm>
#include <atomic>
#include <chrono>
#include <cmath>
#include <map>
#include <random>
#include <set>
#include <thread>

#include "clay/base/job.h"
#include "clay/cage/cage_maker.h"
#include "clay/cage/disk_map.h"
#include "clay/cage/flat_quads.h"
#include "clay/cage/quad_fill.h"
#include "clay/cage/quad_patches.h"
#include "clay/field/primitives.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

/// A sheet of n × m quads that is bent around a cylinder of 10 mm until it nearly closes.
struct Sheet {
  QuadDisk disk;
  std::vector<Vec3d> at;
};
Sheet bentSheet(uint32_t n, uint32_t m) {
  Sheet sheet;
  const auto vertex = [&](uint32_t i, uint32_t j) { return i + j * (n + 1); };
  for (uint32_t j = 0; j <= m; ++j)
    for (uint32_t i = 0; i <= n; ++i) {
      const double angle = 5.5 * i / n;
      sheet.at.emplace_back(10 * std::cos(angle), 10 * std::sin(angle), 20.0 * j / m);
    }
  for (uint32_t j = 0; j < m; ++j)
    for (uint32_t i = 0; i < n; ++i)
      sheet.disk.quads.push_back({vertex(i, j), vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)});
  sheet.disk.sides.resize(4);
  for (uint32_t i = 0; i <= n; ++i) sheet.disk.sides[0].push_back(vertex(i, 0));
  for (uint32_t j = 0; j <= m; ++j) sheet.disk.sides[1].push_back(vertex(n, j));
  for (uint32_t i = 0; i <= n; ++i) sheet.disk.sides[2].push_back(vertex(n - i, m));
  for (uint32_t j = 0; j <= m; ++j) sheet.disk.sides[3].push_back(vertex(0, m - j));
  return sheet;
}

// What is filled as it was lies where it was.
TEST(DiskMap, LeavesWhatDoesNotChange) {
  const Sheet sheet = bentSheet(14, 9);
  QuadDisk is = sheet.disk;
  const QuadFill fill = filled(is.sides, is.quads.size(), [&](uint32_t v) { return sheet.at[v]; });
  is.quads = fill.quads;
  ASSERT_EQ(fill.irregular, 0);
  const auto places = placesOn(sheet.disk, is, [&](uint32_t v) { return sheet.at[v]; });
  EXPECT_EQ(places.size(), 13u * 8);
  std::set<size_t> taken;
  for (const auto& [v, place] : places) {
    const auto near = std::ranges::min_element(sheet.at, {}, [&](const Vec3d& p) { return (p - place).norm(); });
    EXPECT_LT((*near - place).norm(), 1e-3);
    taken.insert(static_cast<size_t>(near - sheet.at.begin()));
  }
  EXPECT_EQ(taken.size(), places.size()) << "each its own";
}

// With another count of edges along a side all of it stays on the sheet, and no quad is turned over, though the sheet
// goes nearly around: the mean of its border lies in the middle of the cylinder.
TEST(DiskMap, StaysOnTheQuadsThatWereThere) {
  std::mt19937 random(3);
  TriangleMesh flat;
  size_t fills = 0;
  for (int round = 0; round < 60; ++round) {
    const uint32_t n = 8 + random() % 8, m = 5 + random() % 5;
    const Sheet sheet = bentSheet(n, m);
    QuadDisk is = sheet.disk;
    // Two sides that are as much longer: two vertices of other than four quads at most.
    const auto more = static_cast<int>(random() % 3) - 1;
    uint32_t next = 1000000;
    std::map<uint32_t, Vec3d> onSides;
    for (const size_t s : {size_t{0}, size_t{1 + random() % 3}}) {
      const BorderSide side = is.sides[s];
      const auto edges = static_cast<size_t>(static_cast<int>(side.size()) - 1 + more);
      BorderSide made{side.front()};
      for (size_t k = 1; k < edges; ++k) {
        const double place = double(k) * double(side.size() - 1) / double(edges);
        const auto before = static_cast<size_t>(place);
        onSides[next] =
            sheet.at[side[before]] +
            (place - double(before)) * (sheet.at[side[std::min(before + 1, side.size() - 1)]] - sheet.at[side[before]]);
        made.push_back(next++);
      }
      made.push_back(side.back());
      is.sides[s] = made;
    }
    const QuadFill fill = filled(is.sides, sheet.disk.quads.size(), [](uint32_t) { return Vec3d(Vec3d::Zero()); });
    if (fill.quads.empty()) continue;
    ++fills;
    is.quads = fill.quads;
    std::map<uint32_t, Vec3d> at = onSides;
    for (const BorderSide& side : sheet.disk.sides)
      for (const uint32_t v : side) at[v] = sheet.at[v];
    flat.positions = sheet.at;
    flat.triangles.clear();
    for (const auto& q : sheet.disk.quads) {
      flat.triangles.push_back({q[0], q[1], q[2]});
      flat.triangles.push_back({q[0], q[2], q[3]});
    }
    const NearestTriangle tree(flat);
    for (const auto& [v, place] : placesOn(sheet.disk, is, [&](uint32_t each) { return sheet.at[each]; })) {
      EXPECT_LT(tree.nearest(place).squared, 1e-12);
      at[v] = place;
    }
    EXPECT_EQ(at.size(), onSides.size() + 2 * (n + m) + fill.added.size());
    for (const auto& q : fill.quads) {
      const Vec3d middle = 0.25 * (at.at(q[0]) + at.at(q[1]) + at.at(q[2]) + at.at(q[3]));
      const Vec3d normal = (at.at(q[2]) - at.at(q[0])).cross(at.at(q[3]) - at.at(q[1]));
      EXPECT_GT(normal.dot(Vec3d(middle.x(), middle.y(), 0)), 0);
    }
  }
  EXPECT_GT(fills, 30u);
}

/// A box of which each edge is a line of so many; its faces are filled. Of an axis, edge e lies at the far end of the
/// next axis where e % 2 is 1, and of the one after where e / 2 is.
QuadMesh boxOf(const std::array<std::array<int, 4>, 3>& counts) {
  QuadMesh mesh;
  for (int c = 0; c < 8; ++c) mesh.positions.emplace_back(8 * (c & 1), 8 * (c >> 1 & 1), 8 * (c >> 2));
  std::map<std::pair<uint32_t, uint32_t>, BorderSide> lines;
  for (size_t axis = 0; axis < 3; ++axis) {
    const size_t u = (axis + 1) % 3, w = (axis + 2) % 3;
    for (size_t e = 0; e < 4; ++e) {
      const auto from = static_cast<uint32_t>((e & 1) << u | (e >> 1) << w), to = from | 1U << axis;
      BorderSide line{from};
      for (int k = 1; k < counts[axis][e]; ++k) {
        line.push_back(static_cast<uint32_t>(mesh.positions.size()));
        const double share = double(k) / counts[axis][e];
        mesh.positions.push_back((1 - share) * mesh.positions[from] + share * mesh.positions[to]);
      }
      line.push_back(to);
      lines[{to, from}] = BorderSide(line.rbegin(), line.rend());
      lines[{from, to}] = line;
    }
  }
  std::set<std::pair<uint32_t, uint32_t>> creases;
  for (const auto& [ends, line] : lines)
    for (size_t k = 0; k + 1 < line.size(); ++k) creases.emplace(line[k], line[k + 1]);
  for (uint32_t axis = 0; axis < 3; ++axis)
    for (const bool far : {false, true}) {
      const uint32_t u = 1U << (axis + 1) % 3, w = 1U << (axis + 2) % 3, at = far ? 1U << axis : 0;
      std::array<uint32_t, 4> corners{at, at + u, at + u + w, at + w};
      if (!far) std::swap(corners[1], corners[3]);
      std::vector<BorderSide> sides;
      for (size_t s = 0; s < 4; ++s) sides.push_back(lines.at({corners[s], corners[(s + 1) & 3]}));
      const QuadFill fill = filled(sides, 64, [](uint32_t) { return Vec3d(Vec3d::Zero()); });
      EXPECT_FALSE(fill.quads.empty());
      const auto first = static_cast<uint32_t>(mesh.positions.size());
      Vec3d middle = Vec3d::Zero();
      for (const uint32_t c : corners) middle += 0.25 * mesh.positions[c];
      mesh.positions.resize(first + fill.added.size(), middle);
      for (auto quad : fill.quads) {
        for (uint32_t& v : quad)
          if (v >= QuadFill::kAdded) v = v - QuadFill::kAdded + first;
        int bits = 0;
        for (size_t s = 0; s < 4; ++s) bits |= int{creases.contains({quad[s], quad[(s + 1) & 3]})} << s;
        mesh.quads.push_back(quad);
        mesh.creases.push_back(static_cast<uint8_t>(bits));
      }
    }
  return mesh;
}

int unevennessByFaces(const QuadWeb& web) {
  int sum = 0;
  std::vector<uint32_t> sector;
  for (uint32_t v = 0; v < web.vertices(); ++v) {
    std::set<uint32_t> seen;
    for (const uint32_t f : web.around(v)) {
      if (seen.contains(f)) continue;
      sum += web.sectorOf(v, f, &sector).uneven(0, true);
      seen.insert(sector.begin(), sector.end());
    }
  }
  return sum;
}

// Each vertex in the mean of those beside it, of a line of those along it: no quad of a flat face folds.
void relax(QuadWeb& web) {
  std::vector<uint32_t> beside;
  for (int round = 0; round < 30; ++round)
    for (uint32_t v = 0; v < web.vertices(); ++v) {
      if (web.around(v).empty() || web.isCorner(v)) continue;
      if (web.isOnCrease(v))
        web.alongCreases(v, beside);
      else
        web.beside(v, beside);
      Vec3d mean = Vec3d::Zero();
      for (const uint32_t each : beside) mean += web.at(each) / double(beside.size());
      web.move(v, mean);
    }
}

// A box whose faces' opposite sides differ. They become equal, through one line and through two, each change gains what
// it says, and lines stay closed networks with the box's eight corners.
TEST(QuadPatches, GiveALineOfCreasesAnotherCountOfEdges) {
  std::map<size_t, int> taken;
  for (unsigned seed = 0; seed < 16; ++seed) {
    std::mt19937 random(seed);
    std::array<std::array<int, 4>, 3> counts{};
    for (auto& axis : counts)
      for (int& each : axis) each = 7 + 2 * static_cast<int>(random() % 2);
    if (seed == 0) counts = {{{7, 7, 9, 9}, {8, 8, 8, 8}, {8, 8, 8, 8}}};  // two that are equal lie beside each other
    QuadWeb web(boxOf(counts));
    relax(web);
    const int before = unevennessByFaces(web);
    QuadPatches patches(web, true);
    for (int round = 0, changed = 1; round < 6 && changed > 0; ++round) {
      changed = 0;
      for (uint32_t v = 0; v < web.vertices(); ++v) {
        if (web.around(v).empty()) continue;
        changed += patches.around(v, 200, [&](const Refill& refill) {
          const int was = unevennessByFaces(web);
          Refill placed = refill;
          placed.carryOver(web);
          const auto first = static_cast<uint32_t>(web.vertices());
          for (const Vec3d& p : placed.added) (void)web.add(p);
          const auto number = [&](uint32_t& each) {
            if (each >= QuadFill::kAdded) each = each - QuadFill::kAdded + first;
          };
          for (auto& quad : placed.made) std::for_each(quad.begin(), quad.end(), number);
          for (BorderSide& line : placed.newLines) std::for_each(line.begin(), line.end(), number);
          (void)web.replace(placed.quads, placed.made, placed.quads, placed.newLines);
          relax(web);
          EXPECT_EQ(was - unevennessByFaces(web), refill.gain);
          EXPECT_GE(refill.gain, refill.lines.empty() ? 1 : 0);
          ++taken[refill.lines.size()];
          return true;
        });
      }
    }
    EXPECT_LE(unevennessByFaces(web), before / 3) << "of " << before << ", seed " << seed;
    const QuadMesh mesh = web.mesh();
    EXPECT_EQ(mesh.positions.size(), mesh.quads.size() + 2) << "a ball";
    EXPECT_EQ(mesh.corners.size(), 8u);
    std::map<uint32_t, int> ends;
    const QuadTopology topology(mesh);  // throws where it is not closed
    for (const auto& edge : topology.edges())
      if (edge.crease)
        for (size_t k = 0; k < 2; ++k) ++ends[mesh.quads[edge.quad[0]][(edge.side[0] + k) & 3]];
    for (const auto& [v, count] : ends)
      EXPECT_EQ(count, std::ranges::find(mesh.corners, v) == mesh.corners.end() ? 2 : 3);
  }
  EXPECT_GT(taken[1], 10);
  EXPECT_GT(taken[2], 0);
}

// A block's quads are grids: of its faces no vertex is irregular but for its corners, where hardly any need be.
TEST(FlatQuads, OfABlockAreNearlyGrids) {
  Grid grid;
  grid.voxelMm = 0.25;
  const Version block = makeBlock(Store::make(), grid, Vec3d(1, 2, 3), Vec3d(40, 30, 20), 0);
  const FlatQuads made = flatQuads(block, 500, false, 2, WorkPart(nullptr));
  EXPECT_LE(QuadTopology(made.mesh).irregular(), 20u) << "30 where lines keep the count that they come with";
  EXPECT_GT(shapesOf(made.mesh).mean, 0.95);
  EXPECT_GT(shapesOf(made.mesh).least, 0.3);
  EXPECT_GE(made.mesh.quads.size(), 450u);
  // Few quads: a row of them is a seventh of all, and where lines lose edges more are drawn at first.
  const FlatQuads few = flatQuads(block, 100, false, 2, WorkPart(nullptr));
  EXPECT_LE(QuadTopology(few.mesh).irregular(), 14u) << "29";
  EXPECT_GE(few.mesh.quads.size(), 85u);
}

// Two balls, a ring and a rod, with the slot of another rod. One disk beside a line looks more even with two edges more
// along it, another one with two fewer: both were done, by turns, for ever.
TEST(FlatQuads, EndWhereALineLooksBetterWithMoreEdgesAndWithFewer) {
  Grid grid;
  grid.voxelMm = 0.5;
  const auto store = [] { return Store::make(); };
  Version clay = makeSphere(store(), grid, Vec3d::Zero(), 10.7);
  clay = combine(clay, makeSphere(store(), grid, Vec3d(9, 6.4, 5.9), 7.2), Combination::join);
  clay = combine(clay, makeTorus(store(), grid, Vec3d(-4.7, 6.7, 5.9), 8.7, 3.9), Combination::join);
  clay = combine(clay, makeRod(store(), grid, Vec3d(-3.4, -3.9, 2), Vec3d(21.8, -20.9, 0.9), 2.8), Combination::cut);
  clay = combine(clay, makeRod(store(), grid, Vec3d(-2.9, 0.3, -2.7), Vec3d(4.6, -14.4, 20.2), 2.6), Combination::join);
  Job job;
  std::atomic<bool> done{false};
  std::thread watch([&] {
    for (int tenths = 0; tenths < 3000 && !done; ++tenths) std::this_thread::sleep_for(std::chrono::milliseconds(100));
    if (!done) job.cancel();
  });
  try {
    EXPECT_GE(flatQuads(clay, 500, false, 2, WorkPart(&job)).mesh.quads.size(), 475u);
  } catch (const Cancelled&) {
    ADD_FAILURE() << "no end after five minutes";
  }
  done = true;
  watch.join();
}

// Lines that get more edges do not crowd them.
TEST(CoarseCage, LinesThatChangeTheirCountKeepEdgesLong) {
  Grid grid;
  grid.voxelMm = 0.5;
  const Version block = combine(makeBlock(Store::make(), grid, Vec3d(1, 2, 3), Vec3d(60, 40, 30), 0),
                                makeCylinder(Store::make(), grid, Vec3d(1, 2, 3), 12, 60), Combination::cut);
  for (const size_t quads : {160u, 180u, 200u, 240u, 280u}) {
    const CageMaker maker(block, quads, true, 2, WorkPart(nullptr));
    const CoarseCage cage = maker.make(WorkPart(nullptr), quads, true);
    double shortest = 1e9;
    for (const auto& quad : cage.mesh.quads)
      for (size_t s = 0; s < 4; ++s)
        shortest = std::min(shortest, (cage.mesh.positions[quad[s]] - cage.mesh.positions[quad[(s + 1) & 3]]).norm());
    EXPECT_GT(shortest, 0.24 * cage.edgeMm) << quads;  // 0.21 where they may become as short as they like
  }
}

}  // namespace
}  // namespace argil::clay
