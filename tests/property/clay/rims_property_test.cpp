// Rims of carves and of laid-on clay against the curves that are known exactly, the tip's middle far above the face and
// far below it: there the wedge of material beside the rim is thinner than a voxel.

#include <gtest/gtest.h>

#include <cstdio>

#include "clay/brush/brush.h"
#include "clay/mesh/mesh_topology.h"
#include "tests/support/tier.h"
#include "tests/unit/clay/sharp_shapes.h"

namespace argil::clay {
namespace {

using namespace testing;

// A block's flat face, `middle` on it, and a ball's way along it.
struct Stroke {
  Version clay;
  Vec3d middle, up;
  std::vector<Vec3d> way;  // of the ball's middle
  double radius = 0;       // of the ball, voxels
  bool add = false;
  std::vector<Vec3d> rim;

  // The place of the way that is nearest to p.
  [[nodiscard]] Vec3d nearest(const Vec3d& p) const {
    Vec3d best = way[0];
    for (size_t i = 0; i + 1 < way.size(); ++i) {
      const Vec3d along = way[i + 1] - way[i];
      const double length2 = along.squaredNorm(),
                   t = length2 > 0 ? std::clamp((p - way[i]).dot(along) / length2, 0.0, 1.0) : 0;
      if (const Vec3d q = way[i] + t * along; (p - q).squaredNorm() < (p - best).squaredNorm()) best = q;
    }
    return best;
  }
};

// What one of the random strokes is like.
struct Kind {
  double radius;  // voxels
  double share;   // of the radius: how far the ball's middle lies above the face
  bool turned;    // anyhow, or the face along the grid (half of them on a plane of voxels)
  bool add;
  bool stroke;  // a straight stroke of many stamps, or one dab
};

Stroke makeStroke(std::mt19937_64& random, const Kind& kind) {
  std::uniform_real_distribution<double> shift(-1, 1);
  Stroke s;
  s.radius = kind.radius;
  s.add = kind.add;
  const Eigen::Matrix3d axes = kind.turned ? randomTurn(random) : Eigen::Matrix3d::Identity();
  s.middle = Vec3d(shift(random), shift(random), shift(random));
  if (!kind.turned && shift(random) < 0) s.middle.z() = 0;
  s.up = axes.col(2);
  TurnedBox box;
  box.axes = axes;
  box.half = Vec3d(30, 30, 14);
  box.centre = s.middle - 14 * s.up;
  const Version block = clayOf(Store::make(), 44, [&](const Vec3d& p) { return box.distance(p); });
  const double above = kind.share * kind.radius, turn = EIGEN_PI * shift(random);
  const Vec3d base = s.middle + above * s.up, x = std::cos(turn) * axes.col(0) + std::sin(turn) * axes.col(1),
              y = s.up.cross(x);
  const Vec3d half = kind.stroke ? Vec3d(9 * x) : Vec3d(Vec3d::Zero());
  s.way = {base - half, base + half};
  // The rim: points of the face as far from the way's foot as the ball's circle on the face is wide.
  const double wide = std::sqrt(kind.radius * kind.radius - above * above);
  for (const double side : {-1.0, 1.0}) {
    const Vec3d end = s.middle + side * half;
    for (double at = 0; at < EIGEN_PI; at += 0.15 / wide)
      s.rim.push_back(end + wide * (std::sin(at) * side * x + std::cos(at) * y));
    for (double at = -1; kind.stroke && at < 1; at += 0.02) s.rim.push_back(s.middle + at * half + side * wide * y);
  }
  BrushStroke stroke(block, Brush::of(kind.add ? Method::add : Method::carve));
  const int stamps = kind.stroke ? 8 : 1;
  for (int i = 0; i < stamps; ++i) {
    const Vec3d step = 2 * half / stamps, from = s.way[0] + i * step;
    stroke.apply(Stamp{from, from + step, kind.radius});
  }
  s.clay = stroke.finish();
  return s;
}

// Distances of rim points from triangles, and the area beside rims whose normal is that of neither side.
struct RimError {
  double squares = 0, most = 0, area = 0, neither = 0;
  size_t points = 0;

  void look(const Stroke& stroke, const TriangleMesh& mesh) {
    const NearestTriangle tree(mesh);
    for (const Vec3d& p : stroke.rim) {
      const double squared = tree.nearest(p).squared;
      squares += squared;
      most = std::max(most, std::sqrt(squared));
      ++points;
    }
    for (const auto& t : mesh.triangles) {
      const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
      const Vec3d facet = (b - a).cross(c - a), middle = (a + b + c) / 3;
      if (std::abs((middle - stroke.middle).dot(stroke.up)) > 4 ||
          (middle - stroke.nearest(middle)).norm() > stroke.radius + 4)
        continue;
      // Six places of the triangle stand for a sixth of its area each.
      for (int i = 0; i < 3; ++i)
        for (int j = 0; i + j < 3; ++j) {
          const Vec3d p = a + (b - a) * ((i + 1 / 3.0) / 3) + (c - a) * ((j + 1 / 3.0) / 3);
          double least = 4;
          for (size_t k = 0; k < stroke.rim.size(); k += 3) least = std::min(least, (stroke.rim[k] - p).squaredNorm());
          if (least > 1) continue;
          const Vec3d ball = (stroke.add ? -1 : 1) * (stroke.nearest(p) - p).normalized();
          const double length = facet.norm(), part = length / 12;
          area += part;
          if (std::max(facet.dot(stroke.up), facet.dot(ball)) < std::cos(25 * EIGEN_PI / 180) * length) neither += part;
        }
    }
  }
  [[nodiscard]] double rms() const { return std::sqrt(squares / static_cast<double>(points)); }
};

// Carve as it works by default cuts with the ball's middle below the face.
TEST(RimProperty, RimsOfDeepAndOfShallowStrokesAreWhereTheyAre) {
  constexpr uint64_t kSeed = 71;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> share(-0.9, 0.9), radius(4.5, 12);
  const int strokes = tests::byTier(32, 1000);
  RimError crisp, fine, draft;
  for (int i = 0; i < strokes; ++i) {
    const Kind kind{.radius = radius(random),
                    .share = share(random),
                    .turned = i % 2 != 0,
                    .add = i / 2 % 2 != 0,
                    .stroke = i / 4 % 2 != 0};
    const Stroke stroke = makeStroke(random, kind);
    RimError here;
    for (const Grade grade : {Grade::draft, Grade::crisp, Grade::fine}) {
      const TriangleMesh mesh = meshOf(stroke.clay, grade);
      ASSERT_TRUE(checkTopology(mesh).closed()) << "stroke " << i << ", seed " << kSeed;
      (grade == Grade::draft ? draft : grade == Grade::crisp ? crisp : fine).look(stroke, mesh);
      if (grade == Grade::crisp) here.look(stroke, mesh);
    }
    EXPECT_LE(here.most, 0.75) << "stroke " << i << ": radius " << kind.radius << ", share " << kind.share;
  }
  for (const auto& [name, error] : {std::pair("draft", draft), std::pair("crisp", crisp), std::pair("fine", fine)})
    std::printf("%s: rims %.3f voxel RMS, %.2f at most; %.1f %% of the area beside them faces neither side\n", name,
                error.rms(), error.most, 100 * error.neither / error.area);
  for (const RimError& error : {crisp, fine}) {
    EXPECT_LE(error.rms(), 0.10);
    EXPECT_LE(error.neither, 0.03 * error.area);
    EXPECT_LE(error.rms(), 0.2 * draft.rms());
  }
}

// The wedge of a deep cut is thinner than a voxel for two voxels: signs alone leave it as teeth.
TEST(RimProperty, ThinWedgesHaveCleanRims) {
  constexpr uint64_t kSeed = 72;
  std::mt19937_64 random(kSeed);
  for (const double share : {-0.5, -0.75, -0.9})
    for (const bool turned : {false, true}) {
      RimError error;
      for (int i = 0; i < tests::byTier(3, 40); ++i) {
        const Kind kind{
            .radius = 5 + 1.5 * (i % 4), .share = share, .turned = turned, .add = false, .stroke = i % 2 != 0};
        const Stroke stroke = makeStroke(random, kind);
        error.look(stroke, meshOf(stroke.clay, Grade::crisp));
      }
      std::printf("middle %.2f radius below, %s: %.3f voxel RMS, %.2f at most, %.1f %% faces neither side\n", -share,
                  turned ? "turned" : "along the grid", error.rms(), error.most, 100 * error.neither / error.area);
      EXPECT_LE(error.rms(), 0.06) << share << " seed " << kSeed;
      EXPECT_LE(error.most, 0.75);
      EXPECT_LE(error.neither, 0.05 * error.area);
    }
}

// Places of triangles near a face that lie off the solid, where a stroke turns: rims meet there at corners.
struct Teeth {
  size_t places = 0, off = 0;
  double most = 0;

  void look(const Stroke& s, const TriangleMesh& mesh) {
    const auto solid = [&](const Vec3d& p) {
      const double face = (p - s.middle).dot(s.up), ball = (p - s.nearest(p)).norm() - s.radius;
      return s.add ? std::min(face, ball) : std::max(face, -ball);
    };
    for (const auto& t : mesh.triangles) {
      const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
      const Vec3d middle = (a + b + c) / 3;
      if (std::abs((middle - s.middle).dot(s.up)) > 3 || (middle - s.nearest(middle)).norm() > s.radius + 4) continue;
      for (const Vec3d& p : {a, b, c, middle, Vec3d((a + b) / 2), Vec3d((b + c) / 2), Vec3d((c + a) / 2)}) {
        const double away = std::abs(solid(p));
        ++places;
        off += away > 0.2;
        most = std::max(most, away);
      }
    }
  }
  [[nodiscard]] double share() const { return static_cast<double>(off) / static_cast<double>(places); }
};

// A point of a rim has a triangle near it whatever stands beside it: teeth are seen from the triangles.
TEST(RimProperty, StrokesThatTurnHaveNoTeeth) {
  constexpr uint64_t kSeed = 74;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> share(-0.7, 0.3), radius(5, 9), shift(-1, 1);
  Teeth crisp, fine, draft;
  for (int i = 0; i < tests::byTier(24, 400); ++i) {
    Stroke s;
    s.radius = radius(random);
    s.add = i % 4 == 3;
    const Eigen::Matrix3d axes = i % 2 != 0 ? randomTurn(random) : Eigen::Matrix3d::Identity();
    s.up = axes.col(2);
    s.middle = Vec3d(shift(random), shift(random), shift(random));
    if (i % 4 == 2) s.middle.z() = 0;
    TurnedBox box;
    box.axes = axes;
    box.half = Vec3d(34, 34, 14);
    box.centre = s.middle - 14 * s.up;
    s.clay = clayOf(Store::make(), 48, [&](const Vec3d& p) { return box.distance(p); });
    for (const double x : {-14.0, -5.0, 4.0, 13.0})
      s.way.push_back(s.middle + axes * Vec3d(x, 7 * shift(random), share(random) * s.radius));
    BrushStroke stroke(s.clay, Brush::of(s.add ? Method::add : Method::carve));
    for (size_t k = 0; k + 1 < s.way.size(); ++k) stroke.apply(Stamp{s.way[k], s.way[k + 1], s.radius});
    s.clay = stroke.finish();
    for (const Grade grade : {Grade::draft, Grade::crisp, Grade::fine}) {
      const TriangleMesh mesh = meshOf(s.clay, grade);
      ASSERT_TRUE(checkTopology(mesh).closed()) << "stroke " << i << ", seed " << kSeed;
      (grade == Grade::draft ? draft : grade == Grade::crisp ? crisp : fine).look(s, mesh);
    }
  }
  for (const auto& [name, teeth] : {std::pair("draft", draft), std::pair("crisp", crisp), std::pair("fine", fine)})
    std::printf("%s: %.3f %% of the places beside rims are more than 0.2 voxel off, %.2f at most\n", name,
                100 * teeth.share(), teeth.most);
  for (const Teeth& teeth : {crisp, fine}) {
    EXPECT_LE(teeth.share(), 0.019 * draft.share()) << "seed " << kSeed;
    EXPECT_LE(teeth.most, 0.75);
  }
}

// A valley or an edge that is rounded by about a voxel is neither a crease nor a face: sharp in one cell and round in
// the next, it is a row of teeth.
TEST(RimProperty, RoundingsOfAVoxelHaveNoMoreTeethThanTheDraft) {
  constexpr uint64_t kSeed = 75;
  for (const double degrees : {60.0, 90.0, 115.0}) {
    const double cosine = std::cos(degrees * std::numbers::pi / 180), sine2 = 1 - cosine * cosine;
    for (const double radius : {0.75, 1.0, 1.25, 1.5, 2.0}) {
      std::mt19937_64 random(kSeed);
      std::uniform_real_distribution<double> shift(-1, 1);
      Teeth teeth[3];
      constexpr Grade kGrades[3] = {Grade::draft, Grade::crisp, Grade::fine};
      for (int i = 0; i < tests::byTier(12, 100); ++i) {
        const Eigen::Matrix3d axes =
            i % 3 == 0 ? randomTurn(random) : Eigen::Matrix3d(Eigen::AngleAxisd(shift(random), Vec3d::UnitZ()));
        const Vec3d middle(shift(random), shift(random), i % 3 == 1 ? 0 : shift(random));
        const bool valley = i % 2 == 0;
        const Vec3d first = axes.col(2), second = cosine * axes.col(2) + std::sqrt(sine2) * axes.col(0);
        // Behind two planes, with a cylinder that touches both where they would meet; or what is left of space.
        const auto rounded = [&](const Vec3d& p) {
          const double a = first.dot(p - middle), b = second.dot(p - middle);
          const double qa = a + radius, qb = b + radius;  // from the cylinder's axis
          const double alongA = (qa - qb * cosine) / sine2, alongB = (qb - qa * cosine) / sine2;
          const double d = alongA > 0 && alongB > 0 ? std::sqrt(qa * alongA + qb * alongB) - radius : std::max(a, b);
          return valley ? -d : d;
        };
        const Version clay =
            clayOf(Store::make(), 24, [&](const Vec3d& p) { return std::max(rounded(p), p.norm() - 18); });
        for (size_t grade = 0; grade < 3; ++grade) {
          const TriangleMesh mesh = meshOf(clay, kGrades[grade]);
          ASSERT_TRUE(checkTopology(mesh).closed());
          for (const auto& t : mesh.triangles) {
            const Vec3d &a = mesh.positions[t[0]], &b = mesh.positions[t[1]], &c = mesh.positions[t[2]];
            const Vec3d at = (a + b + c) / 3 - middle;
            if ((at - at.dot(axes.col(1)) * axes.col(1)).norm() > 4 || at.norm() > 12) continue;
            for (const Vec3d& p : {a, b, c, Vec3d((a + b + c) / 3)}) {
              const double away = std::abs(rounded(p));
              ++teeth[grade].places;
              teeth[grade].off += away > 0.2;
              teeth[grade].most = std::max(teeth[grade].most, away);
            }
          }
        }
      }
      std::printf("%.0f degrees, radius %.2f:", degrees, radius);
      for (const Teeth& each : teeth)
        std::printf(" %.2f %% off by more than 0.2, %.2f;", 100 * each.share(), each.most);
      std::printf("\n");
      for (const Teeth& each : teeth) {
        EXPECT_LE(each.share(), teeth[0].share() + 0.002) << degrees << ", " << radius;
        EXPECT_LE(each.most, 0.7) << degrees << ", " << radius;
      }
    }
  }
}

// Following edits gives the bits of an extraction from nothing, though rims look four voxels beyond their brick.
TEST(RimProperty, FollowedRimsAreThoseOfAFreshSurface) {
  constexpr uint64_t kSeed = 73;
  std::mt19937_64 random(kSeed);
  std::uniform_real_distribution<double> place(-14, 14), depth(-5, 5);
  TurnedBox box;
  box.axes = randomTurn(random);
  box.half = Vec3d(24, 24, 12);
  Version clay = clayOf(Store::make(), 40, [&](const Vec3d& p) { return box.distance(p); });
  for (const Grade grade : {Grade::crisp, Grade::fine}) {
    Surface followed(true, grade);
    followed.update(clay);
    for (int i = 0; i < tests::byTier(12, 200); ++i) {
      BrushStroke stroke(clay, Brush::of(i % 3 == 2 ? Method::add : Method::carve));
      const Vec3d a = box.axes * Vec3d(place(random), place(random), 12 + depth(random)),
                  b = a + box.axes * Vec3d(0.4 * place(random), 0.4 * place(random), 0);
      stroke.apply(Stamp{a, b, 6});
      clay = stroke.finish();
      followed.update(clay);
      Surface fresh(true, grade);
      fresh.update(clay);
      ASSERT_EQ(followed.hash(), fresh.hash()) << "edit " << i << ", seed " << kSeed;
    }
  }
}

}  // namespace
}  // namespace argil::clay
