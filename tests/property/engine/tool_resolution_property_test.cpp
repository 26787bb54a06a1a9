// Every tool against itself: the same strokes on coarse voxels and on fine ones, and on bricks that lie elsewhere.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <map>
#include <span>
#include <unordered_map>
#include <unordered_set>
#include <vector>

#include "clay/field/primitives.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "engine/saving/session.h"
#include "engine/tools/tool_table.h"
#include "tests/support/tier.h"
#include "tests/support/tool_files.h"

namespace argil::engine {
namespace {

using clay::Version;

constexpr double kCoarse = 0.4, kFine = 0.1;  // mm
constexpr double kRadius = 3;                 // mm

// A place of the tool's middle beside the clay, and the clay.
struct Column {
  const char* name;
  double z;  // mm; the face of the block, and the ball's top beyond it, lie at 10 and at 13
  bool ball, crossing;
};
constexpr std::array kColumns{Column{"on the face", 10, false, false}, Column{"across a ridge", 10, false, true},
                              Column{"above the face", 11.5, false, false}, Column{"below the face", 8.5, false, false},
                              Column{"through a ball", 11, true, false}};

std::vector<PathPoint> zigzag(double z) {
  constexpr double kPoints[5][2] = {{-14, -2}, {-5, 2}, {2, -4}, {8, 1}, {14, -2}};
  constexpr int kSteps = 14;
  std::vector<PathPoint> path;
  for (int k = 0; k < 4; ++k)
    for (int i = 0; i < kSteps; ++i) {
      const double t = double(i) / kSteps;
      path.push_back({0.03 * double(path.size()), Vec3d(kPoints[k][0] * (1 - t) + kPoints[k + 1][0] * t,
                                                        kPoints[k][1] * (1 - t) + kPoints[k + 1][1] * t, z)});
    }
  path.push_back({0.03 * double(path.size()), Vec3d(kPoints[4][0], kPoints[4][1], z)});
  return path;
}

Tool toolOf(const ToolRow& row, double radiusMm = kRadius) {
  Tool tool = scriptTool(row);
  tool.radiusMm = radiusMm;
  tests::giveFile(tool);
  return tool;
}

void draw(Session& session, const Tool& tool, const std::vector<PathPoint>& path) {
  session.beginStroke(tool);
  for (const PathPoint& point : path) session.addPoint(point);
  session.endStroke();
}

struct Drawn {
  Version before, after;
};

// The sheet of ordinary strokes: shared/tools/ordinary_strokes.py. `bricks`: where the grid's first voxel lies.
Drawn drawn(const ToolRow& row, const Column& column, double voxelMm, const Vec3d& bricks = Vec3d::Zero()) {
  clay::Grid grid;
  grid.voxelMm = voxelMm;
  grid.originMm = -voxelMm * bricks;
  const auto store = clay::Store::make();
  Session session(Document::of(column.ball ? clay::makeSphere(store, grid, Vec3d::Zero(), 13)
                                           : clay::makeBlock(store, grid, Vec3d::Zero(), {44, 26, 20}, 2)));
  if (column.crossing) draw(session, toolOf(*findTool("ridge")), {{0, Vec3d(-16, 5, 10)}, {1, Vec3d(16, -5, 10)}});
  // What these tools even out, or bring back.
  constexpr std::array kEvenOut{"smooth", "polish", "scrape", "fill", "flatten", "morph"};
  if (std::find(kEvenOut.begin(), kEvenOut.end(), row.id) != kEvenOut.end())
    draw(session, toolOf(*findTool("add"), 2), zigzag(10));
  const Version before = session.version();
  Tool tool = toolOf(row);
  tool.morphTo = 1;
  if (row.file == ToolFile::image) {
    tool.radiusMm = 9;
    draw(session, tool, {{0, Vec3d(0, 0, column.z)}});
  } else {
    draw(session, tool, zigzag(column.z));
  }
  return {before, session.version()};
}

bool shapes(const ToolRow& row) {
  return std::any_of(row.operations.begin(), row.operations.end(),
                     [](const clay::Operation& each) { return each.property == clay::Property::distance; });
}

// A piece of a surface, in mm.
struct Piece {
  Vec3d place, normal;
  double area;
};

std::vector<Piece> piecesOf(const clay::TriangleMesh& mesh) {
  std::vector<Piece> pieces;
  pieces.reserve(mesh.triangles.size());
  for (const auto& [i, j, k] : mesh.triangles) {
    const Vec3d &a = mesh.positions[i], &b = mesh.positions[j], &c = mesh.positions[k], n = (b - a).cross(c - a);
    if (n.norm() > 0) pieces.push_back({(a + b + c) / 3, n.normalized(), n.norm() / 2});
  }
  return pieces;
}

// Cubes of a coarse voxel's edge by what is in them.
struct CellHash {
  size_t operator()(const Coord& c) const { return clay::CoordHash()(c); }
};
Coord cellOf(const Vec3d& mm) {
  const auto at = [](double v) { return int32_t(std::floor(v / kCoarse)); };
  return {at(mm.x()), at(mm.y()), at(mm.z())};
}

class FineSurface {
 public:
  explicit FineSurface(const Version& version)
      : mesh_([&] {
          clay::Surface surface(false, clay::Grade::fine);
          surface.update(version, 2);
          return surface.toMesh();
        }()),
        nearest_(mesh_) {
    for (const Piece& each : piecesOf(mesh_)) cells_[cellOf(each.place)].push_back(each);
  }

  struct Off {
    double p99 = 0;    // coarse voxels
    double share = 0;  // of the area that faces no way that the fine surface there does
  };
  // Normals within the distance that is allowed, or that the piece has, may face any way that one of them does: an edge
  // may lie a little aside.
  [[nodiscard]] Off compare(const std::vector<Piece>& pieces) const {
    std::vector<double> distances;
    double all = 0, off = 0;
    uint32_t hint = UINT32_MAX;
    for (const Piece& each : pieces) {
      const clay::NearestTriangle::Hit hit = nearest_.nearest(each.place, hint);
      hint = hit.triangle;
      const double distance = std::sqrt(hit.squared);
      distances.push_back(distance / kCoarse);
      all += each.area;
      if (!faces(each, std::max(0.35 * kCoarse, 1.05 * distance + kFine))) off += each.area;
    }
    if (distances.empty()) return {};
    const auto at = distances.begin() + ptrdiff_t(double(distances.size()) * 0.99);
    std::nth_element(distances.begin(), at, distances.end());
    return {*at, off / all};
  }

 private:
  [[nodiscard]] bool faces(const Piece& piece, double within) const {
    constexpr double kCosine25 = 0.9063;
    const Coord cell = cellOf(piece.place);
    for (int i = 0; i < 27; ++i) {
      const auto found = cells_.find(cell + Coord{i / 9 - 1, i / 3 % 3 - 1, i % 3 - 1});
      if (found == cells_.end()) continue;
      for (const Piece& each : found->second)
        if ((each.place - piece.place).norm() < within && each.normal.dot(piece.normal) > kCosine25) return true;
    }
    return false;
  }

  clay::TriangleMesh mesh_;
  clay::NearestTriangle nearest_;
  std::unordered_map<Coord, std::vector<Piece>, CellHash> cells_;
};

// Cells within two voxels of what a stroke changed.
std::unordered_set<Coord, CellHash> changedCells(const Drawn& clay, const clay::TriangleMesh& mesh) {
  clay::Sampler before(clay.before), after(clay.after);
  std::unordered_set<Coord, CellHash> cells;
  for (const Vec3d& mm : mesh.positions) {
    const Vec3d p = clay.after.grid().toVoxel(mm);
    if (std::abs(before.trilinear(p) - after.trilinear(p)) < 0.05f) continue;
    for (int i = 0; i < 125; ++i) cells.insert(cellOf(mm) + Coord{i / 25 - 2, i / 5 % 5 - 2, i % 5 - 2});
  }
  return cells;
}

// Pieces carried onto the field's own surface, where that is found.
std::vector<Piece> onField(const Version& version, const std::vector<Piece>& pieces) {
  clay::Sampler sampler(version);
  std::vector<Piece> carried;
  for (const Piece& each : pieces) {
    Vec3d p = version.grid().toVoxel(each.place);
    Vec3f g;
    for (int k = 0; k < 5; ++k) {
      const double value = sampler.tricubic(p, g);
      const Vec3d step = value * g.cast<double>() / std::max(double(g.squaredNorm()), 0.25);
      p -= step / std::max(step.norm(), 1.0);
    }
    if (std::abs(sampler.tricubic(p, g)) > 0.02f || g.squaredNorm() < 0.04f) continue;
    carried.push_back({version.grid().toWorld(p), g.cast<double>().normalized(), each.area});
  }
  return carried;
}

class EveryToolAgainstItself : public ::testing::TestWithParam<size_t> {
 protected:
  [[nodiscard]] const ToolRow& row() const { return toolTable()[GetParam()]; }
};

// What is allowed on the field's surface: distance in voxels, share of the area.
struct Allowed {
  double distance = 0.35, share = 0.03;
};
Allowed allowedFor(std::string_view tool) {
  // A blend is no wider than the band, which is 0.3 mm on the fine voxels.
  if (tool == "wax") return {0.60, 0.03};
  // Where two surfaces are farther apart than the band, going back is a switch.
  if (tool == "morph") return {2.2, 0.25};
  // Clay drawn out thinner than a voxel is rounded at coarse voxels and there at fine ones.
  if (tool == "tug") return {0.45, 0.09};
  if (tool == "twist") return {0.60, 0.03};
  // The first plane of the stroke lies on a bump that five voxels hold.
  if (tool == "scrape") return {0.55, 0.06};
  if (tool == "flatten") return {0.40, 0.03};
  // Walls of the image 2.5 voxels high are as steep as voxels can hold.
  if (tool == "emboss") return {0.55, 0.13};
  // The shape turns with the surface below its middle, which has edges of the stamps before.
  if (tool == "stamp" || tool == "stamp_paint") return {0.80, 0.03};
  return {};
}

TEST_P(EveryToolAgainstItself, LeavesTheSameOnCoarseVoxelsAsOnFineOnes) {
  if (!shapes(row())) return;
  const size_t columns = tests::byTier<size_t>(2, kColumns.size());
  for (const Column& column : std::span(kColumns).first(columns)) {
    const Drawn coarse = drawn(row(), column, kCoarse), fine = drawn(row(), column, kFine);
    clay::Surface surface(false);
    surface.update(coarse.after, 2);
    const clay::TriangleMesh mesh = surface.toMesh();
    const auto cells = changedCells(coarse, mesh);
    std::vector<Piece> pieces = piecesOf(mesh);
    std::erase_if(pieces, [&](const Piece& each) { return !cells.contains(cellOf(each.place)); });
    const std::vector<Piece> field = onField(coarse.after, pieces);
    EXPECT_GE(double(field.size()), 0.97 * double(pieces.size())) << row().id << ' ' << column.name;
    const FineSurface::Off off = FineSurface(fine.after).compare(field);
    const FineSurface::Off own = FineSurface(fine.after).compare(pieces);
    std::printf("%s, %s: field %.3f voxels p99, %.2f %% of the area, of %zu pieces; surface %.3f, %.2f %%\n",
                row().id.data(), column.name, off.p99, 100 * off.share, field.size(), own.p99, 100 * own.share);
    const Allowed allowed = allowedFor(row().id);
    EXPECT_LE(off.p99, allowed.distance) << row().id << ' ' << column.name;
    EXPECT_LE(off.share, allowed.share) << row().id << ' ' << column.name;
  }
}

// Edges at which a surface turns by more than 125° between triangles of more than a tenth of a voxel squared.
size_t foldedEdges(const clay::TriangleMesh& mesh, double voxelMm) {
  constexpr double kCosine = -0.57, kLeastArea = 0.1;
  std::map<std::pair<uint32_t, uint32_t>, Vec3d> normals;
  size_t count = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
    const Vec3d twice = (b - a).cross(c - a) / (voxelMm * voxelMm);
    if (twice.norm() < 2 * kLeastArea) continue;
    for (size_t k = 0; k < 3; ++k) {
      const auto [edge, first] = normals.try_emplace(std::minmax(t[k], t[(k + 1) % 3]), twice.normalized());
      count += !first && edge->second.dot(twice.normalized()) < kCosine;
    }
  }
  return count;
}

// How many such edges a tool may leave: none in the draft. Some are right, where cuts and beads meet at less than 55°.
// The fine grade turns triangles over within faces on planes of the grid, beside rounded feet.
size_t foldsAllowed(std::string_view tool, clay::Grade grade) {
  if (grade == clay::Grade::draft) return 0;
  struct Row {
    std::string_view tool;
    size_t crisp, fine;
  };
  constexpr std::array kRows{Row{"carve", 50, 60},       Row{"add", 22, 25},    Row{"stamp", 35, 40},
                             Row{"stamp_paint", 35, 40}, Row{"smooth", 10, 80}, Row{"polish", 36, 85},
                             Row{"scrape", 15, 16},      Row{"fill", 12, 60},   Row{"flatten", 12, 35},
                             Row{"morph", 15, 17},       Row{"tug", 4, 14}};
  for (const Row& each : kRows)
    if (each.tool == tool) return grade == clay::Grade::crisp ? each.crisp : each.fine;
  return grade == clay::Grade::crisp ? 0 : 6;
}

// A tooth is a fold that no stroke made.
TEST_P(EveryToolAgainstItself, LeavesFewFolds) {
  if (!shapes(row())) return;
  for (const Column& column : kColumns) {
    const Drawn clay = drawn(row(), column, kCoarse);
    std::printf("%s, %s:", row().id.data(), column.name);
    for (const clay::Grade grade : {clay::Grade::draft, clay::Grade::crisp, clay::Grade::fine}) {
      clay::Surface surface(false, grade);
      surface.update(clay.after, 2);
      const size_t folded = foldedEdges(surface.toMesh(), kCoarse);
      std::printf(" %zu", folded), std::fflush(stdout);
      EXPECT_LE(folded, foldsAllowed(row().id, grade)) << row().id << ' ' << column.name;
    }
    std::printf("\n");
  }
}

// Bricks are eight voxels: a stroke on a grid that begins elsewhere leaves the same, so no edge follows their borders.
TEST_P(EveryToolAgainstItself, LeavesTheSameWhereverBricksLie) {
  if (!shapes(row())) return;
  for (const Column& column : kColumns) {
    if (column.crossing) continue;
    const Drawn here = drawn(row(), column, kCoarse);
    clay::Surface surface(false);
    surface.update(here.after, 2);
    const clay::TriangleMesh mesh = surface.toMesh();
    clay::Sampler mine(here.after);
    double worst = 0;
    std::vector<double> off;
    for (const Vec3d& bricks : {Vec3d(4, 4, 4), Vec3d(3, 5, 2)}) {
      const Drawn there = drawn(row(), column, kCoarse, bricks);
      clay::Sampler other(there.after);
      for (const Vec3d& mm : mesh.positions) {
        const double by =
            std::abs(other.trilinear(there.after.grid().toVoxel(mm)) - mine.trilinear(here.after.grid().toVoxel(mm)));
        worst = std::max(worst, by);
        if (by > 0) off.push_back(by);
      }
    }
    std::sort(off.begin(), off.end());
    const double p99 = off.empty() ? 0 : off[size_t(0.99 * double(off.size()))];
    std::printf("%s, %s: %.4f voxels at most, %.4f p99\n", row().id.data(), column.name, worst, p99);
    EXPECT_LE(p99, 0.15) << row().id << ' ' << column.name;
    EXPECT_LE(worst, 0.9) << row().id << ' ' << column.name;
  }
}

INSTANTIATE_TEST_SUITE_P(Tools, EveryToolAgainstItself, ::testing::Range(size_t{0}, toolTable().size()),
                         [](const auto& each) { return std::string(toolTable()[each.param].id); });

// An image of one height on a flat face: the whole square is raised, up to its rim, wherever the tool's middle is.
TEST(Embossing, FillsItsSquareHoweverHighTheToolStands) {
  const auto white = std::make_shared<const clay::HeightImage>(4, 4, std::vector<uint8_t>(16, 255));
  for (const double radius : {6.0, 12.5, 25.0})
    for (const double above : {0.0, 0.5, -0.6, 0.92}) {
      clay::Grid grid;
      grid.voxelMm = 0.5;
      Session session(Document::of(clay::makeBlock(clay::Store::make(), grid, Vec3d::Zero(), {60, 60, 4}, 0.5)));
      Tool tool = toolOf(*findTool("emboss"), radius);
      tool.content.image = white;
      tool.heightMm = 1;
      draw(session, tool, {{0, Vec3d(0, 0, 2 + above * radius)}});
      clay::Sampler sampler(session.version());
      // Towards its border the image fades over 1 mm at most, or two voxels; towards the upper and lower face too.
      const double rim = std::max(1.0, std::min(0.8, 0.1 * radius)), inner = radius - rim - 0.75;
      const double up = std::min((1 - std::abs(above)) * radius / rim, 1.0);
      const auto heightAt = [&](double x, double y) {
        double z = 4;
        while (z > 0 && sampler.trilinear(grid.toVoxel({x, y, z})) > 0) z -= 0.01;
        return z - 2;
      };
      for (double x = -inner; x <= inner; x += inner / 8)
        for (double y = -inner; y <= inner; y += inner / 8)
          ASSERT_NEAR(heightAt(x, y), up, 0.08) << radius << ", " << above << ": " << x << ' ' << y;
      for (double s = -radius; s <= radius; s += radius / 8)
        for (const double outside : {-radius - 0.75, radius + 0.75}) {
          ASSERT_NEAR(heightAt(s, outside), 0, 0.03) << radius << ", " << above << ": " << s;
          ASSERT_NEAR(heightAt(outside, s), 0, 0.03) << radius << ", " << above << ": " << s;
        }
    }
}

}  // namespace
}  // namespace argil::engine
