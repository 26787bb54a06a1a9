// Every number that the import of a mesh tells, beside the true one: messages × models. A message that this table does
// not know fails, too.

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <functional>
#include <map>
#include <numbers>
#include <optional>
#include <regex>
#include <string>
#include <vector>

#include "clay/base/error.h"
#include "clay/import/mesh_to_clay.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/nearest_triangle.h"
#include "clay/mesh/wall_thickness.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "tests/unit/clay/test_meshes.h"

namespace argil::engine {
namespace {

using clay::TriangleMesh;
using clay::testing::append;
using clay::testing::box;
using clay::testing::flip;
using clay::testing::icosphere;
using clay::testing::meshVolume;
using Vec2d = Eigen::Vector2d;

// What is true of a mesh, by how it was made.
struct Model {
  std::string name;
  TriangleMesh mesh;
  uint64_t bodies = 1, openEdges = 0, withoutArea = 0, repeated = 0, disagreeing = 0, turnedFaces = 0, turnedBodies = 0,
           crowdedEdges = 0;
  uint64_t crossings = 0;  ///< Pairs of triangles, in general position, of which an edge of one runs through the other.
  bool insideOut = false;
  bool sharp = false;        ///< Has edges below 30°, thinner than any voxel.
  double newSurfaceMm2 = 0;  ///< Of flat holes alone.
  double thinMm = 0;         ///< Thickness of its thinnest wall, where it has one.
};

TriangleMesh turned(TriangleMesh mesh, double degrees, const Vec3d& about, const Vec3d& by = Vec3d(0.31, -0.17, 0.43)) {
  const Eigen::Matrix3d turn =
      Eigen::AngleAxisd(degrees * std::numbers::pi / 180, about.normalized()).toRotationMatrix();
  for (Vec3d& p : mesh.positions) p = turn * p + by;
  return mesh;
}

// An outline that is star-shaped around its first corner, extruded; with a top of another size.
TriangleMesh extruded(const std::vector<Vec2d>& outline, double height, double topScale = 1, bool lid = true) {
  TriangleMesh mesh;
  const auto n = static_cast<uint32_t>(outline.size());
  for (const double z : {0.0, height})
    for (const Vec2d& p : outline) {
      const Vec2d at = z > 0 ? Vec2d(topScale * p) : p;
      mesh.positions.emplace_back(at.x(), at.y(), z);
    }
  for (uint32_t i = 0; i < n; ++i) {
    const uint32_t j = (i + 1) % n;
    mesh.triangles.push_back({i, j, i + n});
    mesh.triangles.push_back({j, j + n, i + n});
  }
  for (uint32_t i = 2; i < n; ++i) {
    mesh.triangles.push_back({0, i, i - 1});
    if (lid) mesh.triangles.push_back({n, n + i - 1, n + i});
  }
  return mesh;
}

std::vector<Vec2d> polygon(int sides, double radius) {
  std::vector<Vec2d> outline;
  for (int i = 0; i < sides; ++i) {
    const double angle = 2 * std::numbers::pi * (i + 0.25) / sides;
    outline.emplace_back(radius * std::cos(angle), radius * std::sin(angle));
  }
  return outline;
}
double areaOf(const std::vector<Vec2d>& outline) {
  double twice = 0;
  for (size_t i = 0; i < outline.size(); ++i) {
    const Vec2d &a = outline[i], &b = outline[(i + 1) % outline.size()];
    twice += a.x() * b.y() - a.y() * b.x();
  }
  return twice / 2;
}

TriangleMesh ring(double radius, double tube, uint32_t around, uint32_t across) {
  TriangleMesh mesh;
  for (uint32_t i = 0; i < around; ++i)
    for (uint32_t j = 0; j < across; ++j) {
      const double u = 2 * std::numbers::pi * i / around, v = 2 * std::numbers::pi * j / across;
      const double out = radius + tube * std::cos(v);
      mesh.positions.emplace_back(out * std::cos(u), out * std::sin(u), tube * std::sin(v));
    }
  for (uint32_t i = 0; i < around; ++i)
    for (uint32_t j = 0; j < across; ++j) {
      const auto at = [&](uint32_t x, uint32_t y) { return x % around * across + y % across; };
      mesh.triangles.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
      mesh.triangles.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
    }
  return mesh;
}

uint64_t crossingsOf(const TriangleMesh& mesh) {
  const auto volume = [&](uint32_t a, uint32_t b, uint32_t c, uint32_t d) {
    const auto& p = mesh.positions;
    return (p[b] - p[a]).cross(p[c] - p[a]).dot(p[d] - p[a]);
  };
  const auto runsThrough = [&](const auto& edges, const auto& face) {
    const auto& [a, b, c] = face;
    for (size_t e = 0; e < 3; ++e) {
      const uint32_t p = edges[e], q = edges[(e + 1) % 3];
      const double one = volume(p, q, a, b), two = volume(p, q, b, c), three = volume(p, q, c, a);
      if (volume(a, b, c, p) * volume(a, b, c, q) < 0 && one * two > 0 && two * three > 0) return true;
    }
    return false;
  };
  uint64_t pairs = 0;
  for (size_t i = 0; i < mesh.triangles.size(); ++i)
    for (size_t k = i + 1; k < mesh.triangles.size(); ++k)
      pairs += runsThrough(mesh.triangles[i], mesh.triangles[k]) || runsThrough(mesh.triangles[k], mesh.triangles[i]);
  return pairs;
}

// The models are 40 to 60 mm long: voxels of 1 mm and less.
std::vector<Model> models() {
  std::vector<Model> all;
  const auto add = [&](const std::string& name, TriangleMesh mesh) -> Model& {
    Model& model = all.emplace_back();
    model.name = name;
    model.mesh = std::move(mesh);
    return model;
  };
  const std::array<std::pair<double, Vec3d>, 3> turns{
      {{0, Vec3d::UnitX()}, {33, Vec3d(1, 0.4, 0.2)}, {71, Vec3d(-0.3, 1, 0.5)}}};
  for (const auto& [degrees, about] : turns) {
    const std::string how = std::to_string(int(degrees));
    add("cube " + how, turned(box({0, 0, 0}, {40, 40, 40}), degrees, about));
    add("slab " + how, turned(box({0, 0, 0}, {50, 40, 9}), degrees, about));
    add("bar " + how, turned(box({0, 0, 0}, {60, 7, 7}), degrees, about));
    add("three sides " + how, turned(extruded(polygon(3, 20), 40), degrees, about));
    add("eight sides " + how, turned(extruded(polygon(8, 15), 40), degrees, about));
    add("frustum " + how, turned(extruded(polygon(7, 20), 40, 0.6), degrees, about));
    for (const int sides : {4, 6, 24}) {
      Model& cup = add("cup of " + std::to_string(sides) + " sides " + how,
                       turned(extruded(polygon(sides, 20), 30, 1, false), degrees, about));
      cup.openEdges = uint64_t(sides);
      cup.newSurfaceMm2 = areaOf(polygon(sides, 20));
    }
    for (const double thick : {0.3, 0.7, 1.3, 2.2}) {
      Model& plate =
          add("plate of " + std::to_string(thick) + " " + how, turned(box({0, 0, 0}, {50, 40, thick}), degrees, about));
      plate.thinMm = thick;
    }
    for (const double thick : {0.3, 0.6}) {
      // A block with a wall that stands on it, as an outline around a corner that sees all of it.
      const std::vector<Vec2d> outline{{20, 20}, {0, 20}, {0, 0}, {20 + thick, 0}, {20 + thick, 50}, {20, 50}};
      Model& tray =
          add("wall of " + std::to_string(thick) + " on a block " + how, turned(extruded(outline, 40), degrees, about));
      tray.thinMm = thick;
    }
  }
  add("ball", icosphere({0, 0, 0}, 20, 4));
  add("ball of few faces", icosphere({0.3, 0.2, 0.1}, 20, 1));
  add("ring", ring(20, 6, 40, 16));
  add("ring that lies askew", turned(ring(18, 4, 24, 9), 50, {1, 1, 0}));
  add("arrow", extruded({{10, 10}, {0, 40}, {0, 0}, {40, 0}, {40, 10}}, 30)).sharp = true;
  {
    TriangleMesh hollow = box({0, 0, 0}, {40, 40, 40}), inner = box({10, 10, 10}, {30, 30, 30});
    for (auto& t : inner.triangles) flip(t);
    append(hollow, inner);
    add("hollow cube", hollow).bodies = 2;
    append(hollow, box({50, 0, 0}, {60, 10, 10}));
    add("hollow cube and another", hollow).bodies = 3;
  }
  {
    TriangleMesh two = box({0, 0, 0}, {20, 20, 20});
    append(two, box({25.3, 0, 0}, {45, 20, 20}));
    add("two cubes apart", two).bodies = 2;
    TriangleMesh crossing = box({0, 0, 0}, {20, 20, 20});
    append(crossing, box({15.3, 5, 4}, {45, 15, 13}));
    Model& overlapping = add("two that overlap", crossing);
    overlapping.bodies = 2;
    overlapping.crossings = crossingsOf(crossing);
  }
  {
    Model& out = add("inside out", box({0, 0, 0}, {40, 30, 20}));
    for (auto& t : out.mesh.triangles) flip(t);
    out.insideOut = true;
    Model& one = add("a face the other way", icosphere({0, 0, 0}, 20, 3));
    flip(one.mesh.triangles[17]);
    one.disagreeing = 3;
    one.turnedFaces = 1;
    Model& twice = add("faces twice", icosphere({0, 0, 0}, 20, 3));
    for (const size_t i : {3u, 50u, 90u}) twice.mesh.triangles.push_back(twice.mesh.triangles[i]);
    twice.repeated = 3;
    Model& flat = add("triangles without an area", box({0, 0, 0}, {40, 30, 20}));
    flat.mesh.triangles.push_back({0, 0, 1});
    flat.mesh.triangles.push_back({2, 3, 3});
    flat.withoutArea = 2;
    Model& other = add("one of two inside out", box({0, 0, 0}, {20, 20, 20}));
    TriangleMesh second = box({30, 0, 0}, {45, 20, 20});
    for (auto& t : second.triangles) flip(t);
    append(other.mesh, second);
    other.bodies = 2;
    other.turnedBodies = 1;
    Model& holes = add("two lids gone", box({0, 0, 0}, {40, 40, 40}));
    holes.mesh.triangles.erase(holes.mesh.triangles.begin(), holes.mesh.triangles.begin() + 4);
    holes.openEdges = 8;
    Model& wedge = add("wedge", extruded({{0, 0}, {50, 0}, {50, 12}}, 40));
    wedge.sharp = true;
  }
  return all;
}

struct Made {
  clay::Imported imported;
  clay::TopologyReport surface;
};
Made importAt(const TriangleMesh& mesh, double voxelMm) {
  clay::ImportOptions options;
  options.grid.voxelMm = voxelMm;
  Made made{clay::meshToClay(clay::Store::make(), mesh, options), {}};
  clay::Surface surface(false, clay::Grade::fine);
  surface.update(made.imported.version, 2);
  made.surface = clay::checkTopology(surface.toMesh());
  return made;
}

// The numbers that a sentence tells, as often as it is told.
class Table {
 public:
  void near(const std::string& message, double told, double right, double part, double least = 0) {
    ++told_[message];
    EXPECT_NEAR(told, right, std::max(part * std::abs(right), least)) << message;
  }
  void count(const std::string& message, uint64_t told, uint64_t right) {
    ++told_[message];
    EXPECT_EQ(told, right) << message;
  }
  void print() const {
    for (const auto& [message, times] : told_) std::printf("%5d  %s\n", times, message.c_str());
  }
  [[nodiscard]] size_t messages() const { return told_.size(); }

 private:
  std::map<std::string, int> told_;
};

// Of the mesh what has no surface of the clay within 3/4 of a voxel; all of it in its part of the volume, where less
// than half of the volume is left.
struct Lost {
  double mm2 = 0;
  Vec3d atMm = Vec3d::Zero();
};
Lost lostOf(const Model& model, const Made& made, double voxelMm) {
  clay::Surface surface(false, clay::Grade::fine);
  surface.update(made.imported.version, 2);
  const TriangleMesh skin = surface.toMesh();
  const double left = std::max(0.0, made.surface.volume) / meshVolume(model.mesh);
  std::optional<clay::NearestTriangle> tree;
  if (!skin.triangles.empty()) tree.emplace(skin);
  Lost lost;
  double all = 0;
  Vec3d middle = Vec3d::Zero();
  constexpr int kParts = 120;  // a side of a triangle
  for (const auto& [i, j, k] : model.mesh.triangles) {
    const Vec3d &a = model.mesh.positions[i], &b = model.mesh.positions[j], &c = model.mesh.positions[k];
    const double area = (b - a).cross(c - a).norm() / (2 * kParts * kParts);
    for (int x = 0; x < kParts; ++x)
      for (int y = 0; x + y < kParts; ++y)
        for (const double off : {1 / 3.0, 2 / 3.0}) {
          if (off > 0.5 && x + y + 1 >= kParts) continue;
          const Vec3d p = a + (b - a) * ((x + off) / kParts) + (c - a) * ((y + off) / kParts);
          all += area, middle += area * p;
          if (tree && !(std::sqrt(tree->nearest(p).squared) > 0.75 * voxelMm)) continue;
          lost.mm2 += area, lost.atMm += area * p;
        }
  }
  if (left < 0.5 && all * (1 - left) > lost.mm2) return {all * (1 - left), middle / all};
  if (lost.mm2 > 0) lost.atMm /= lost.mm2;
  return lost;
}

void checkSentence(const Model& model, const Made& made, double voxelMm, const std::string& sentence, Table& table,
                   double& lessTold, bool& bodiesTold) {
  std::smatch m;
  const auto is = [&](const char* pattern) { return std::regex_search(sentence, m, std::regex(pattern)); };
  const auto number = [&](size_t i) { return std::stod(m[i]); };
  const auto whole = [&](size_t i) { return uint64_t(std::stoull(m[i])); };
  const clay::MeshLosses& losses = made.imported.report.losses;
  if (is("^The mesh has (\\d+) triangles? in (\\d+) bod")) {
    table.count("triangles", whole(1), model.mesh.triangles.size());
    table.count("bodies of the mesh", whole(2), model.bodies);
  } else if (is("^(\\d+) triangles? (is|are) without an area")) {
    table.count("triangles without an area", whole(1), model.withoutArea);
  } else if (is("^(\\d+) faces? lies? on corners")) {
    table.count("faces twice", whole(1), model.repeated);
  } else if (is("^Faces disagreed .* along (\\d+) edges?; (\\d+) faces? (was|were) turned")) {
    table.count("edges that disagree", whole(1), model.disagreeing);
    table.count("faces turned", whole(2), model.turnedFaces);
  } else if (is("^The whole mesh was inside out")) {
    table.count("inside out", 1, model.insideOut);
  } else if (is("^(\\d+) bod(y|ies) (was|were) inside out")) {
    table.count("bodies turned", whole(1), model.turnedBodies);
  } else if (is("^The mesh is open along (\\d+) edges?; (about (.*) mm² of new surface)?")) {
    table.count("open edges", whole(1), model.openEdges);
    if (model.newSurfaceMm2 > 0) {
      ASSERT_TRUE(m[2].matched) << sentence;
      table.near("new surface", number(3), model.newSurfaceMm2, 0.03);
    }
  } else if (is("^Walls about (.*) mm thin are lost at a voxel of (.*) mm: (.*) % of the volume, (.*) mm² on both "
                "sides, around (.*), (.*), (.*) mm\\. Voxels of (.*) mm would keep them")) {
    lessTold = number(3);
    table.near("voxel", number(2), voxelMm, 0.005);
    ASSERT_GT(model.thinMm, 0) << sentence;
    table.near("thickness of lost walls", number(1), model.thinMm, 0.05);
    const Lost lost = lostOf(model, made, voxelMm);
    table.near("area of lost walls", number(4), lost.mm2, 0.15, 100 * voxelMm * voxelMm);
    table.near("place of lost walls", (Vec3d(number(5), number(6), number(7)) - lost.atMm).norm(), 0, 0, 2.5);
    const double keeps = number(8);
    const Made kept = importAt(model.mesh, keeps);
    table.near("voxels that keep lost walls", kept.surface.volume, meshVolume(model.mesh), 0.01);
    EXPECT_EQ(kept.imported.report.losses.lostMm2, 0) << keeps;
  } else if (is("^Walls thinner than the voxel of (.*) mm are lost: (.*) mm² on both sides, around (.*), (.*), (.*) "
                "mm")) {
    ASSERT_TRUE(model.thinMm > 0 || model.sharp) << sentence;
    table.near("area of lost walls", number(2), lostOf(model, made, voxelMm).mm2, 0.15, 100 * voxelMm * voxelMm);
  } else if (is("^The clay has (.*) % (less|more) volume")) {
    lessTold = m[2] == "less" ? number(1) : -number(1);
  } else if (is("^(\\d+) pairs? of triangles cross")) {
    table.count("triangles that cross", whole(1), model.crossings);
  } else if (is("^(\\d+) specks? of (.*) mm³ together")) {
    table.count("specks", whole(1), losses.specks);
    EXPECT_LE(number(2), double(whole(1)) * clay::kSpeckVoxels * std::pow(voxelMm, 3) * 1.01) << sentence;
  } else if (is("^The clay has (\\d+) bod(y|ies)( and (\\d+) cavit)?")) {
    bodiesTold = true;
    table.count("bodies of the clay", whole(1) + (m[3].matched ? whole(4) : 0), made.surface.bodies);
  } else if (!is("^Walls inside the material or too thin")) {
    ADD_FAILURE() << "a message that nobody has looked at: " << sentence;
  }
}

TEST(ToldNumbers, OfImportsAreTheTrueOnes) {
  Table table;
  const std::vector<Model> all = models();
  EXPECT_GE(all.size(), 50u);
  for (const Model& model : all) {
    const double right = std::abs(meshVolume(model.mesh));
    for (const double voxelMm : {1.0, 0.5, 0.37}) {
      SCOPED_TRACE(model.name + " at " + std::to_string(voxelMm));
      Made made;
      try {
        made = importAt(model.mesh, voxelMm);
      } catch (const Error& e) {
        // Nothing of it is as thick as a voxel.
        EXPECT_NE(std::string(e.what()).find("as thick as a voxel"), std::string::npos) << e.what();
        EXPECT_LT(model.thinMm, voxelMm * 1.01) << e.what();
        EXPECT_GT(model.thinMm, 0) << e.what();
        continue;
      }
      double lessTold = 0;
      bool bodiesTold = false;
      for (const std::string& sentence : made.imported.report.sentences())
        checkSentence(model, made, voxelMm, sentence, table, lessTold, bodiesTold);
      if (made.imported.report.sound() && model.bodies == 1) {
        const double less = 100 * (1 - made.surface.volume / right);
        if (std::abs(less) > 0.5 + 0.05) table.near("change of volume", lessTold, less, 0, 0.06);
        if (std::abs(less) < 0.5 - 0.05) {
          EXPECT_EQ(lessTold, 0) << less;
        }
      } else {
        EXPECT_EQ(lessTold, 0) << "bodies may overlap, and holes bound nothing";
      }
      EXPECT_EQ(bodiesTold, made.surface.bodies != model.bodies);
    }
  }
  table.print();
  EXPECT_GE(table.messages(), 14u);
}

// The voxel that is said to keep all walls does.
TEST(ToldNumbers, VoxelsThatAreSaidToKeepAllWallsKeepThem) {
  int tried = 0;
  for (const Model& model : models()) {
    const double keeps = clay::wallThickness(model.mesh, clay::WorkPart(nullptr)).keepingVoxelMm();
    if (!(keeps > 0.12) || model.sharp || !clay::checkTopology(model.mesh).solid()) continue;
    SCOPED_TRACE(model.name + " at " + std::to_string(keeps));
    if (model.thinMm > 0) {
      EXPECT_LE(keeps, model.thinMm);
    }
    const Made made = importAt(model.mesh, keeps);
    ++tried;
    const clay::ImportReport& report = made.imported.report;
    EXPECT_EQ(report.losses.lostMm2, 0);
    EXPECT_EQ(report.losses.bodies + report.losses.cavities == model.bodies || model.bodies > 1, true);
    if (model.bodies == 1) {
      EXPECT_NEAR(made.surface.volume / std::abs(meshVolume(model.mesh)), 1, 0.05);
    }
  }
  EXPECT_GE(tried, 30);
}

}  // namespace
}  // namespace argil::engine
