// Rims of ball cuts, the commonest crease there is: the live grade against the circles that are known exactly.

#include <gtest/gtest.h>

#include <cstdio>
#include <numeric>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/whole/boolean.h"
#include "tests/support/tier.h"
#include "tests/unit/clay/sharp_shapes.h"

namespace argil::clay {
namespace {

using namespace testing;

struct Rim {
  Version clay;
  std::vector<Vec3d> points;                     // of the circle
  std::function<double(const Vec3d&)> distance;  // zero on the surface of the solid near the cut
  Vec3d centre;                                  // of the ball
  double tip;                                    // its radius, voxels
};

// A ball cut into the flat side of a block, its centre `above` the surface. Turned and placed at random.
Rim cutIntoPlane(std::mt19937_64& random, double tip, double above) {
  std::uniform_real_distribution<double> shift(-1, 1);
  TurnedBox box;
  box.axes = randomTurn(random);
  const Vec3d middle(shift(random), shift(random), shift(random)), up = box.axes.col(2);
  box.half = Vec3d(20, 20, 10);
  box.centre = middle - 10 * up;
  const Version block = clayOf(Store::make(), 32, [&](const Vec3d& p) { return box.distance(p); });
  Rim rim;
  rim.tip = tip;
  rim.centre = middle + above * up;
  const double radius = std::sqrt(tip * tip - above * above);
  for (int i = 0; i < 400; ++i) {
    const double turn = 2 * EIGEN_PI * i / 400;
    rim.points.push_back(middle + radius * (std::cos(turn) * box.axes.col(0) + std::sin(turn) * box.axes.col(1)));
  }
  rim.distance = [=, centre = rim.centre](const Vec3d& p) {
    return std::max((p - middle).dot(up), tip - (p - centre).norm());
  };
  BrushStroke stroke(block, Brush::of(Method::carve));
  stroke.apply(Stamp{rim.centre, rim.centre, tip});
  rim.clay = stroke.finish();
  return rim;
}

// The same into a sphere of 40 voxels.
Rim cutIntoSphere(std::mt19937_64& random, double tip, double above) {
  constexpr double kSphere = 40;
  std::uniform_real_distribution<double> shift(-1, 1);
  const Eigen::Matrix3d axes = randomTurn(random);
  const Vec3d pole(shift(random), shift(random), shift(random)), up = axes.col(2), middle = pole - kSphere * up;
  Grid grid;
  grid.voxelMm = 1;
  Rim rim;
  rim.tip = tip;
  rim.centre = pole + above * up;
  const double apart = kSphere + above, height = (apart * apart + kSphere * kSphere - tip * tip) / (2 * apart),
               radius = std::sqrt(kSphere * kSphere - height * height);
  for (int i = 0; i < 400; ++i) {
    const double turn = 2 * EIGEN_PI * i / 400;
    rim.points.push_back(middle + height * up + radius * (std::cos(turn) * axes.col(0) + std::sin(turn) * axes.col(1)));
  }
  rim.distance = [=, centre = rim.centre](const Vec3d& p) {
    return std::max((p - middle).norm() - kSphere, tip - (p - centre).norm());
  };
  BrushStroke stroke(makeSphere(Store::make(), grid, middle, kSphere), Brush::of(Method::carve));
  stroke.apply(Stamp{rim.centre, rim.centre, tip});
  rim.clay = stroke.finish();
  return rim;
}

// Voxels: of the circles' points from the surface, and of the surface's vertices around the cut from the solid.
struct Off {
  double squares = 0, most = 0, vertexMost = 0;
  size_t points = 0;
  std::vector<double> all;

  void look(const Rim& rim, Grade grade) {
    const TriangleMesh mesh = meshOf(rim.clay, grade);
    ASSERT_TRUE(checkTopology(mesh).closed());
    const NearestTriangle tree(mesh);
    for (const Vec3d& p : rim.points) {
      const double squared = tree.nearest(p).squared;
      squares += squared;
      all.push_back(std::sqrt(squared));
      most = std::max(most, all.back());
      ++points;
    }
    for (const Vec3d& p : mesh.positions)
      if ((p - rim.centre).norm() < rim.tip + 3) vertexMost = std::max(vertexMost, std::abs(rim.distance(p)));
  }
  [[nodiscard]] double rms() const { return std::sqrt(squares / static_cast<double>(points)); }
  [[nodiscard]] double quantile(double q) {
    std::sort(all.begin(), all.end());
    return all[static_cast<size_t>(q * static_cast<double>(all.size() - 1))];
  }
};

// Of a tip's radius in voxels, with its middle as far above or below the surface as this part of the radius: `share`
// 0.5 makes edges of 60° to 120°.
struct Tip {
  double radius, share;
  double rms, most99, better;  // bounds: voxels, and how many times better than the draft
};

// Places off the grid.
TEST(Rims, TheLiveGradeHasThemWhereTheyAre) {
  const uint64_t seed = 11;
  std::mt19937_64 random(seed);
  const bool all = tests::longTier();
  for (const Tip& tip : {Tip{10, 0.5, 0.035, 0.15, 12}, Tip{5, 0.5, 0.08, 0.4, 5}, Tip{3, 0.5, 0.19, 0.62, 2},
                         Tip{6, 0.75, 0.095, 0.42, 5}})
    for (const bool sphere : {false, true}) {
      std::uniform_real_distribution<double> above(-tip.share * tip.radius, tip.share * tip.radius);
      const bool finely = all || tip.radius == 10;
      const int places = all ? 100 : finely ? 25 : 15;
      Off draft, crisp, fine;
      for (int i = 0; i < places; ++i) {
        const double by = above(random);
        const Rim rim = sphere ? cutIntoSphere(random, tip.radius, by) : cutIntoPlane(random, tip.radius, by);
        crisp.look(rim, Grade::crisp);
        draft.look(rim, Grade::draft);
        if (finely) fine.look(rim, Grade::fine);
      }
      const auto print = [&](const char* grade, Off& off) {
        std::printf("tip of %.0f, %.0f°, %s, %s: %.3f RMS, 99 %% within %.2f, %.2f at most; vertices %.2f\n",
                    tip.radius, 90 - std::asin(tip.share) * 180 / M_PI, sphere ? "sphere" : "plane", grade, off.rms(),
                    off.quantile(0.99), off.most, off.vertexMost);
      };
      print("draft", draft);
      print("crisp", crisp);
      if (finely) print("fine", fine);
      EXPECT_GE(draft.rms(), tip.better * crisp.rms());
      EXPECT_LE(crisp.rms(), tip.rms) << "seed " << seed;
      EXPECT_LE(crisp.quantile(0.99), tip.most99);
      EXPECT_LE(crisp.vertexMost, 0.6);
      if (finely) {
        EXPECT_LE(fine.rms(), 1.3 * tip.rms);
      }
    }
}

// Vertices whose normals say that they stand on a crease. No number is −32768, which readers take for −32767.
size_t onCreases(const Surface& surface) {
  size_t count = 0;
  surface.forEach([&](const BrickMesh& mesh) {
    for (const PackedNormal normal : mesh.normals) {
      EXPECT_GT(normal.u, -32768);
      EXPECT_GT(normal.v, -32768);
      count += normal.v % 2 != 0 ? 1 : 0;
    }
  });
  return count;
}

// How far the shading is from the face's true normal, in degrees, on both sides of the rims of a ball in a plane: as
// render/shaders/clay.frag has it, with a triangle's own normal at vertices on creases unless it is a sliver's.
std::vector<double> shadingOff(std::mt19937_64& random, double tip, double away, Grade grade, int places) {
  std::uniform_real_distribution<double> above(-0.5 * tip, 0.5 * tip);
  std::vector<double> off;
  for (int place = 0; place < places; ++place) {
    const Rim rim = cutIntoPlane(random, tip, above(random));
    Surface surface(true, grade);
    surface.update(rim.clay);
    const TriangleMesh mesh = surface.toMesh();
    std::vector<PackedNormal> normals;
    surface.forEach(
        [&](const BrickMesh& brick) { normals.insert(normals.end(), brick.normals.begin(), brick.normals.end()); });
    const NearestTriangle tree(mesh);
    const Vec3d middle = std::accumulate(rim.points.begin(), rim.points.end(), Vec3d(Vec3d::Zero())) / 400.0;
    const Vec3d up = (rim.points[0] - middle).cross(rim.points[1] - middle).normalized();
    for (const Vec3d& at : rim.points)
      for (const bool ball : {false, true}) {
        Vec3d p = at + away * (at - middle).normalized(), normal = up;
        if (ball) {
          const Vec3d out = (at - rim.centre) / tip, down = (up.dot(out) * out - up).normalized();
          p = rim.centre + tip * (std::cos(away / tip) * out + std::sin(away / tip) * down);
          normal = (rim.centre - p) / tip;
        }
        const auto corners = tree.corners(tree.nearest(p).triangle);
        const Vec3d &a = mesh.positions[corners[0]], &b = mesh.positions[corners[1]], &c = mesh.positions[corners[2]];
        const Vec3d on = nearestOnTriangle(p, a, b, c), facet = (b - a).cross(c - a);
        const std::array<double, 3> share{(b - on).cross(c - on).norm(), (c - on).cross(a - on).norm(),
                                          (a - on).cross(b - on).norm()};
        Vec3d others = Vec3d::Zero();
        double onCrease = 0;
        for (size_t k = 0; k < 3; ++k) {
          const PackedNormal n = normals[corners[k]];
          if (n.v % 2 != 0)
            onCrease += share[k];
          else
            others += share[k] * n.unpack().cast<double>();
        }
        const Vec3d own = facet.normalized();
        const double all = share[0] + share[1] + share[2], left = all - onCrease;
        const double t = left > 0.001 * all ? std::clamp(own.dot(others.normalized()) / 0.3, 0.0, 1.0) : 1.0,
                     trust = t * t * (3 - 2 * t);
        const Vec3d shading = others + onCrease * (trust * own + (1 - trust) * others / std::max(left, 0.001 * all));
        off.push_back(std::acos(std::clamp(shading.normalized().dot(normal), -1.0, 1.0)) * 180 / EIGEN_PI);
      }
  }
  std::sort(off.begin(), off.end());
  return off;
}

// Beside a rim its faces have their own light, where the draft goes over from one to the other.
TEST(Rims, FacesHaveTheirOwnShadingUpToTheRim) {
  const int places = tests::longTier() ? 100 : 15;
  struct Bound {
    double away, rms, most90, most99;  // voxels; degrees
  };
  for (const auto& [away, most, most90, most99] :
       {Bound{0.25, 4, 5, 10}, Bound{0.5, 2.5, 4, 6}, Bound{1.0, 1.1, 2, 4}}) {
    std::array<std::vector<double>, 2> off;
    for (const Grade grade : {Grade::draft, Grade::crisp}) {
      std::mt19937_64 random(12);
      off[grade == Grade::crisp] = shadingOff(random, 10, away, grade, places);
    }
    const auto of = [](const std::vector<double>& all, double part) {
      return all[static_cast<size_t>(part * static_cast<double>(all.size() - 1))];
    };
    const auto rms = [](const std::vector<double>& all) {
      return std::sqrt(std::inner_product(all.begin(), all.end(), all.begin(), 0.0) / static_cast<double>(all.size()));
    };
    std::printf(
        "%.2f voxel beside rims shading is off by: draft %.1f° RMS, half within %.1f°, 90 %% within %.1f°; "
        "crisp %.1f°, %.1f°, %.1f°, 99 %% within %.1f°\n",
        away, rms(off[0]), of(off[0], 0.5), of(off[0], 0.9), rms(off[1]), of(off[1], 0.5), of(off[1], 0.9),
        of(off[1], 0.99));
    EXPECT_LE(rms(off[1]), std::min(most, 0.4 * rms(off[0])));
    EXPECT_LE(of(off[1], 0.5), 3);
    EXPECT_LE(of(off[1], 0.9), most90);
    EXPECT_LE(of(off[1], 0.99), most99);
  }
}

// A face that lies on a plane of the grid has its rim on sides of cells, where the last bits say in which. Edges of 66°
// and more: sharper ones stand out of the cells that are crossed.
TEST(Rims, OfFacesOnPlanesOfTheGridAreWhereTheyAre) {
  Grid grid;
  grid.voxelMm = 1;
  std::vector<double> off;
  for (int turn = 0; turn < 6; ++turn) {
    const double side = turn % 2 != 0 ? -1 : 1, apart = 1.6 * turn;
    const Vec3d centre(16 + side * apart, 0.3, 0.1 * turn);
    const Version half = combine(makeSphere(Store::make(), grid, centre, 20),
                                 makeBlock(Store::make(), grid, Vec3d(16 - side * 30, 0, 0), Vec3d(60, 60, 60), 0),
                                 Combination::intersect);
    const TriangleMesh mesh = meshOf(half, Grade::crisp);
    const NearestTriangle tree(mesh);
    const double radius = std::sqrt(400 - apart * apart);
    for (int i = 0; i < 1000; ++i) {
      const double at = 2 * EIGEN_PI * i / 1000;
      const Vec3d p(16, centre.y() + radius * std::cos(at), centre.z() + radius * std::sin(at));
      off.push_back(std::sqrt(tree.nearest(p).squared));
    }
  }
  std::sort(off.begin(), off.end());
  const double rms =
      std::sqrt(std::inner_product(off.begin(), off.end(), off.begin(), 0.0) / static_cast<double>(off.size()));
  std::printf("on planes of the grid: %.3f voxel RMS, 99 %% within %.2f, %.2f at most\n", rms,
              off[off.size() * 99 / 100], off.back());
  EXPECT_LE(rms, 0.04);
  EXPECT_LE(off[off.size() * 99 / 100], 0.15);
  EXPECT_LE(off.back(), 0.25);
}

// Straight edges of such a face, of 66° to 120°, too: those that lie along the grid are on the sides of four cells.
TEST(Rims, StraightOnPlanesOfTheGridAreWhereTheyAre) {
  std::mt19937_64 random(21);
  std::uniform_real_distribution<double> shift(-1, 1);
  std::vector<double> off;
  for (int turn = 0; turn < 36; ++turn) {
    const double edge = (66 + 1.5 * turn) * EIGEN_PI / 180, spin = turn % 3 == 0   ? EIGEN_PI * shift(random)
                                                                   : turn % 3 == 1 ? 0.02 * shift(random)
                                                                                   : 0;
    const Vec3d along(0, -std::sin(spin), std::cos(spin)), middle(10, 0, 0),
        normal(-std::cos(edge), std::sin(edge) * std::cos(spin), std::sin(edge) * std::sin(spin)),
        onEdge(16, turn % 6 == 5 ? 2 : 3 * shift(random), 3 * shift(random));
    const auto shape = [&](const Vec3d& p) {
      return std::max({p.x() - onEdge.x(), normal.dot(p - onEdge), (p - middle).norm() - 18});
    };
    const TriangleMesh mesh = meshOf(clayOf(Store::make(), 40, shape), Grade::crisp);
    const NearestTriangle tree(mesh);
    for (int i = -400; i <= 400; ++i) {
      const Vec3d p = onEdge + 0.02 * i * along;
      if ((p - middle).norm() < 15) off.push_back(std::sqrt(tree.nearest(p).squared));
    }
  }
  const double rms = std::sqrt(std::inner_product(off.begin(), off.end(), off.begin(), 0.0) /
                               static_cast<double>(off.size())),
               most = *std::max_element(off.begin(), off.end());
  std::printf("straight, on planes of the grid: %.3f voxel RMS, %.2f at most\n", rms, most);
  EXPECT_LE(rms, 0.025);
  EXPECT_LE(most, 0.2);
}

// Of strokes, too: the two lines at which a groove of many stamps begins.
TEST(Rims, GroovesBeginWhereTheyShould) {
  std::mt19937_64 random(14);
  std::uniform_real_distribution<double> shift(-1, 1);
  std::vector<double> off;
  for (int place = 0; place < 12; ++place) {
    TurnedBox box;
    box.axes = randomTurn(random);
    box.half = Vec3d(26, 20, 10);
    const Vec3d middle(shift(random), shift(random), shift(random)), way = box.axes.col(0), up = box.axes.col(2);
    box.centre = middle - 10 * up;
    const double tip = 8 + 4 * shift(random), above = tip * (0.55 + 0.3 * shift(random));
    BrushStroke stroke(clayOf(Store::make(), 40, [&](const Vec3d& p) { return box.distance(p); }),
                       Brush::of(Method::carve));
    for (int k = -12; k < 12; ++k) {
      const Vec3d at = middle + above * up + k * way;
      stroke.apply(Stamp{at, at + way, tip});
    }
    const TriangleMesh mesh = meshOf(stroke.finish(), Grade::crisp);
    const NearestTriangle tree(mesh);
    const Vec3d aside = std::sqrt(tip * tip - above * above) * box.axes.col(1);
    for (const int side : {-1, 1})
      for (int i = -100; i <= 100; ++i)
        off.push_back(std::sqrt(tree.nearest(middle + side * aside + 0.1 * i * way).squared));
  }
  const double rms = std::sqrt(std::inner_product(off.begin(), off.end(), off.begin(), 0.0) /
                               static_cast<double>(off.size())),
               far = static_cast<double>(std::count_if(off.begin(), off.end(), [](double d) { return d > 0.25; })) /
                     static_cast<double>(off.size());
  std::printf("grooves: %.3f voxel RMS, %.2f %% above a quarter\n", rms, 100 * far);
  EXPECT_LE(rms, 0.055);
  EXPECT_LE(far, 0.01);
}

// The same clay elsewhere on the grid, with bricks that end elsewhere, has the same vertices.
TEST(Rims, WhereBricksEndMakesNoDifference) {
  std::mt19937_64 random(13);
  for (int turn = 0; turn < 10; ++turn) {
    TurnedBox box;
    box.axes = randomTurn(random);
    box.half = Vec3d(11, 10, 9);
    const Vec3d ball = box.axes * Vec3d(2, -3, 9);
    std::array<std::vector<std::array<double, 3>>, 2> places;
    std::array<size_t, 2> sharp{};
    const Vec3d shift(turn % 8 + 1, 3 - turn, 5);
    for (const size_t moved : {0, 1}) {
      const Vec3d by = moved ? shift : Vec3d(Vec3d::Zero());
      const Version clay = clayOf(Store::make(), 30, [&](const Vec3d& p) {
        return std::max(box.distance(p - by), 6 - (p - by - ball).norm());
      });
      Surface surface(true, Grade::crisp);
      surface.update(clay);
      sharp[moved] = onCreases(surface);
      for (const Vec3d& p : surface.toMesh().positions) {
        const Vec3d q = p - by;
        places[moved].push_back({q.x(), q.y(), q.z()});
      }
      std::sort(places[moved].begin(), places[moved].end());
    }
    EXPECT_NEAR(static_cast<double>(sharp[0]), static_cast<double>(sharp[1]), 0.02 * static_cast<double>(sharp[0]))
        << turn;
    ASSERT_EQ(places[0].size(), places[1].size());
    // Each has its like close by. Rims of acute wedges are fitted for groups of cells that lie on the grid, so they
    // differ as much as such fits do.
    constexpr double kFits = 0.03;
    size_t alone = 0;
    for (const auto& p : places[0]) {
      const auto first =
          std::lower_bound(places[1].begin(), places[1].end(), std::array<double, 3>{p[0] - kFits, -1e9, 0});
      bool found = false;
      for (auto at = first; at != places[1].end() && (*at)[0] < p[0] + kFits && !found; ++at)
        found = std::abs((*at)[1] - p[1]) < kFits && std::abs((*at)[2] - p[2]) < kFits;
      alone += found ? 0 : 1;
    }
    EXPECT_LE(static_cast<double>(alone), 0.02 * static_cast<double>(places[0].size())) << turn;
  }
}

// Smooth clay has the draft's vertices, to the bit: nothing there looks like a crease.
TEST(Rims, SmoothClayIsTheDrafts) {
  Grid grid;
  grid.voxelMm = 1;
  const Version version = makeSphere(Store::make(), grid, Vec3d(0.3, -0.2, 0.1), 30);
  Surface draft(true, Grade::draft), crisp(true, Grade::crisp);
  draft.update(version);
  crisp.update(version);
  EXPECT_EQ(draft.hash(), crisp.hash());
  EXPECT_EQ(onCreases(crisp), 0u);
}

// Of edges that lie anyhow, too: few vertices of a rounding of two voxels are taken for a crease, none of three.
TEST(Rims, RoundedEdgesThatAreTurnedStayRound) {
  std::mt19937_64 random(5);
  for (const double round : {2.0, 3.0, 5.0}) {
    size_t sharp = 0, all = 0;
    double squares[2] = {};
    for (int turn = 0; turn < 8; ++turn) {
      TurnedBox box;
      box.axes = randomTurn(random);
      box.half = Vec3d(12, 10, 9);
      box.round = round;
      const Version clay = clayOf(Store::make(), 24, [&](const Vec3d& p) { return box.distance(p); });
      for (const Grade grade : {Grade::draft, Grade::crisp}) {
        Surface surface(true, grade);
        surface.update(clay);
        if (grade == Grade::crisp) sharp += onCreases(surface), all += surface.vertexCount();
        for (const Vec3d& p : surface.toMesh().positions)
          squares[grade == Grade::crisp] += box.distance(p) * box.distance(p);
      }
    }
    std::printf("rounded by %.0f: %zu of %zu vertices on creases, error %.3f of the draft's\n", round, sharp, all,
                std::sqrt(squares[1] / squares[0]));
    EXPECT_LE(static_cast<double>(sharp), (round < 3 ? 0.0025 : 0) * static_cast<double>(all));
    EXPECT_LE(squares[1], 1.02 * squares[0]);
  }
}

// Edges that are rounded are no creases.
TEST(Rims, RoundedEdgesStayRound) {
  Grid grid;
  grid.voxelMm = 1;
  for (const double round : {1.0, 1.5, 2.0, 3.0, 5.0}) {
    const auto worst = [&](Grade grade) {
      const Vec3d half(12, 10, 8), inner = half - Vec3d::Constant(round), centre(0.3, -0.2, 0.1);
      const Version block = makeBlock(Store::make(), grid, centre, 2 * half, round);
      double most = 0;
      for (const Vec3d& p : meshOf(block, grade).positions)
        most = std::max(most, std::abs(((p - centre).cwiseAbs() - inner).cwiseMax(0.0).norm() - round));
      return most;
    };
    const double draft = worst(Grade::draft), crisp = worst(Grade::crisp);
    std::printf("rounded by %.1f voxels: draft %.2f, crisp %.2f off\n", round, draft, crisp);
    // A rounding of a voxel and a half is nearly an edge.
    EXPECT_LE(crisp, round < 2 ? 0.5 : draft + 0.01) << round;
  }
}

// Normals of all vertices, those on edges and bends too, point away from the clay.
TEST(Rims, NormalsPointOutwards) {
  Grid grid;
  grid.voxelMm = 1;
  for (const double round : {0.0, 1.0, 1.5, 2.0, 3.0}) {
    const Vec3d half(12, 10, 8), inner = half - Vec3d::Constant(round), centre(0.3, -0.2, 0.1);
    for (const bool hollow : {false, true}) {
      Version clay = makeBlock(Store::make(), grid, centre, 2 * half, round);
      if (hollow) clay = combine(makeBlock(clay.store(), grid, centre, Vec3d::Constant(40), 0), clay, Combination::cut);
      for (const Grade grade : {Grade::draft, Grade::crisp, Grade::fine}) {
        Surface surface(true, grade);
        surface.update(clay);
        size_t looked = 0, wrong = 0;
        surface.forEach([&](const BrickMesh& mesh) {
          for (size_t i = 0; i < mesh.normals.size(); ++i) {
            const Vec3d p = (mesh.brick * kBrickEdge).toVec3d() + mesh.positions[i].cast<double>() - centre;
            if (hollow && (p.cwiseAbs() - half).maxCoeff() > 4) continue;  // the outside of the hollow block
            Vec3d away = (p.cwiseAbs() - inner).cwiseMax(0.05).cwiseProduct(p.cwiseSign()).normalized();
            if (hollow) away = -away;
            // A vertex of an edge has the normal of one of its faces.
            const bool edge = round < 1 && ((p.cwiseAbs() - half).array() > -1).count() > 1;
            ++looked;
            wrong += mesh.normals[i].unpack().cast<double>().dot(away) > (edge ? 0 : 0.4) ? 0 : 1;
          }
        });
        EXPECT_GT(looked, 1000u);
        EXPECT_EQ(wrong, 0u) << "rounded by " << round << (hollow ? ", a hollow" : "") << ", grade " << int(grade);
      }
    }
  }
}

// Faces that look along an axis have their normals at the ends of what the numbers hold.
TEST(Rims, NormalsSayWhichVerticesAreOnACrease) {
  Grid grid;
  grid.voxelMm = 1;
  const Version box = makeBlock(Store::make(), grid, Vec3d(0.3, -0.2, 0.1), Vec3d(20, 20, 20), 0);
  Surface draft(true, Grade::draft), crisp(true, Grade::crisp);
  draft.update(box);
  crisp.update(box);
  EXPECT_EQ(onCreases(draft), 0u);
  // Twelve edges of twenty voxels.
  EXPECT_GT(onCreases(crisp), 12u * 18);
  EXPECT_LT(onCreases(crisp), 12u * 24);
}

}  // namespace
}  // namespace argil::clay
