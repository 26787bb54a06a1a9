// What tools that move clay promise.

#include <gtest/gtest.h>

#include <random>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/sampler.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

constexpr std::array kWarps{Method::tug, Method::smudge, Method::pinch, Method::crease, Method::twist};

// A sphere of 40 voxels about the origin.
Version sphere(const std::shared_ptr<Store>& store) {
  return makeSphere(store, Grid{}, Vec3d::Zero(), 20);
}

// Stamps a tenth of a radius apart along a segment.
std::vector<Stamp> along(const Vec3d& from, const Vec3d& to, double radius) {
  const int count = std::max(1, static_cast<int>(std::ceil((to - from).norm() / std::max(0.1 * radius, 0.5))));
  std::vector<Stamp> stamps;
  for (int i = 0; i < count; ++i)
    stamps.push_back({from + (to - from) * i / count, from + (to - from) * (i + 1) / count, radius, 1.0f});
  return stamps;
}

Version stroked(const Version& base, Method method, const std::vector<Stamp>& stamps, int publishEvery = 1000,
                float amount = 1) {
  BrushStroke stroke(base, Brush::of(method, amount));
  int n = 0;
  for (const Stamp& each : stamps) {
    stroke.apply(each);
    if (++n % publishEvery == 0) (void)stroke.publish();
  }
  return stroke.finish();
}

Stamp mirrored(const Stamp& s, int axis, double plane) {
  Stamp m = s;
  m.a[axis] = 2 * plane - s.a[axis];
  m.b[axis] = 2 * plane - s.b[axis];
  m.axes.row(axis) *= -1;
  return m;
}

TEST(Warping, TugsThereAndBackDriftLittle) {
  const auto store = Store::make();
  Version now = sphere(store);
  const Vec3d from = Vec3d(1, 0.3, -0.2).normalized() * 40, to = from + Vec3d(0.6, 0.5, 0.4).normalized() * 10;
  for (int i = 0; i < 50; ++i) {
    now = stroked(now, Method::tug, along(from, to, 12));
    now = stroked(now, Method::tug, along(to, from, 12));
    store->collect();
  }
  Sampler field(now);
  double sum = 0, near = 0;
  int count = 0, nearCount = 0;
  now.forEachBrick([&](const Brick& brick) {
    for (int i = 0; i < kBrickVoxels; ++i) {
      if (std::abs(brick.phi(i)) >= 1) continue;
      const Vec3d p = (brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7}).toVec3d();
      const double error = brick.phi(i) - (p.norm() - 40);
      sum += error * error, ++count;
      if ((p - from).norm() < 12) near += error * error, ++nearCount;
    }
  });
  std::printf("100 tugs of 10 voxels there and back: %.4f voxels RMS over the sphere, %.4f under the tip\n",
              std::sqrt(sum / count), std::sqrt(near / nearCount));
  EXPECT_LE(std::sqrt(sum / count), 0.2);
  Surface surface(false);
  surface.update(now);
  const TopologyReport report = checkTopology(surface.toMesh());
  EXPECT_TRUE(report.closed());
  EXPECT_EQ(report.bodies, 1u);
}

TEST(Warping, TugCarriesTheClayUnderItsMiddle) {
  const Version base = sphere(Store::make());
  const Version after = stroked(base, Method::tug, along({40, 0, 0}, {48, 0, 0}, 14));
  Sampler field(after);
  // The pole goes all the way; a smudge of the same way lags.
  EXPECT_NEAR(field.trilinear(Vec3d(48, 0, 0)), 0, 0.1);
  const Version smudged = stroked(base, Method::smudge, along({40, 0, 0}, {48, 0, 0}, 14));
  Sampler other(smudged);
  EXPECT_GT(other.trilinear(Vec3d(46, 0, 0)), 0.2);
  EXPECT_LT(other.trilinear(Vec3d(41, 0, 0)), -0.2);
}

TEST(Warping, PinchNarrowsAndCreaseCutsOrRaises) {
  const auto store = Store::make();
  const Version base = sphere(store);
  const auto stamps = along({40, -15, 0}, {40, 15, 0}, 8);
  const Version low = stroked(base, Method::crease, stamps, 1000, -1),
                high = stroked(base, Method::crease, stamps, 1000, 1);
  Sampler valley(low), ridge(high);
  EXPECT_GT(valley.trilinear(Vec3d(39.2, 0, 0)), 0.1);
  EXPECT_LT(ridge.trilinear(Vec3d(40.8, 0, 0)), -0.1);
}

TEST(Warping, MirroredBricksHaveMirroredBits) {
  // Centre on a brick face, so that the sphere is its own mirror image.
  Grid grid;
  const auto store = Store::make();
  for (const Method method : kWarps)
    for (int axis = 0; axis < 3; ++axis) {
      const double plane = -0.5;
      // voxels: 24 about (−0.5, −0.5, −0.5)
      const Version base = makeSphere(store, grid, Vec3d::Constant(-0.25), 12);
      const auto brush = Brush::of(method, method == Method::crease ? -1 : 1);
      BrushStroke stroke(base, brush);
      std::mt19937_64 random(5 + static_cast<uint64_t>(axis));
      std::uniform_real_distribution<double> u(-1, 1);
      Vec3d at(17 + 3 * u(random), 14 + 3 * u(random), 7 * u(random));
      at[axis] = 5;
      for (int i = 0; i < 8; ++i) {
        const Vec3d next = at + Vec3d(u(random), u(random), u(random)) * 3;
        Stamp one{at, next, 9.7, 0.9f};
        one.axes = Eigen::AngleAxisf(0.7f, Vec3f(1, 2, 3).normalized()).toRotationMatrix();
        for (int k = 0; k < 3; ++k)
          one.a[k] = std::round(one.a[k] * 65536) / 65536, one.b[k] = std::round(one.b[k] * 65536) / 65536;
        const Stamp images[2] = {one, mirrored(one, axis, plane)};
        stroke.apply(images);
        at = one.b;
      }
      const Version after = stroke.finish();
      uint64_t changed = 0;
      Sampler start(base), now(after);
      after.forEachBrick([&](const Brick& brick) {
        for (int i = 0; i < kBrickVoxels; ++i) {
          const Coord c = brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
          Coord m = c;
          int32_t& along = axis == 0 ? m.x : axis == 1 ? m.y : m.z;
          along = -1 - along;
          ASSERT_EQ(brick.phi(i), now.voxel(m))
              << static_cast<int>(method) << " axis " << axis << " at " << c.x << ' ' << c.y << ' ' << c.z;
          changed += brick.phi(i) != start.voxel(c);
        }
      });
      EXPECT_GT(changed, 500u) << static_cast<int>(method);
    }
}

TEST(Warping, EqualBitsOnEverySimdTargetHoweverPublished) {
  const auto run = [](int publishEvery) {
    const auto store = Store::make();
    Version now = sphere(store);
    std::vector<uint64_t> hashes;
    for (const Method method : kWarps) {
      now = stroked(now, method, along({40, -6, 3}, {37, 12, 6}, 11), publishEvery);
      hashes.push_back(now.hash());
    }
    return hashes;
  };
  const auto reference = run(1);
  tests::forEachSimdTarget([&](const std::string& name) { EXPECT_EQ(run(1000), reference) << name; });
}

TEST(Warping, MaskedVoxelsStayToTheBit) {
  const auto store = Store::make();
  const Version plain = sphere(store);
  Editor editor(plain);
  std::array<uint8_t, kBrickVoxels> half{};
  for (int i = 0; i < kBrickVoxels; ++i)
    half[static_cast<size_t>(i)] = static_cast<uint8_t>((i & 7) < 4 ? 255 : 36 * (7 - (i & 7)));
  editor.setChannel(Channel::mask, {4, 0, 0}, half);
  editor.setChannel(Channel::mask, {5, 0, 0}, half);
  editor.setChannelTile(Channel::mask, {4, 1, 0}, true);
  const Version base = editor.commit();
  for (const Method method : kWarps) {
    const Version after = stroked(base, method, along({40, -5, 2}, {42, 8, 6}, 10));
    Sampler was(base), is(after);
    int differ = 0;
    for (int x = 32; x < 48; ++x)
      for (int y = -8; y < 16; ++y)
        for (int z = -8; z < 16; ++z) {
          const Coord c{x, y, z};
          // Masks count in the band alone.
          const bool covered =
              std::abs(was.voxel(c)) < 3 &&
              base.find(Channel::mask, c >> kBrickBits).value(Brick::offset(x & 7, y & 7, z & 7)) == 255;
          if (covered) {
            ASSERT_EQ(was.voxel(c), is.voxel(c)) << static_cast<int>(method);
          }
          differ += was.voxel(c) != is.voxel(c);
        }
    EXPECT_GT(differ, 100) << static_cast<int>(method);
  }
}

// Random strokes of tug and smudge from one piece to the next: it stays one piece, closed, without holes through it.
TEST(Warping, NothingTearsOrOpens) {
  const uint64_t seed = 21;
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> u(-1, 1);
  std::normal_distribution<double> normal;
  const auto store = Store::make();
  Version now = sphere(store);
  for (int s = 0; s < 60; ++s) {
    Vec3d from = Vec3d(normal(random), normal(random), normal(random)).normalized() * 40;
    const double radius = 8 + 4 * (u(random) + 1);
    const Vec3d to = from + Vec3d(u(random), u(random), u(random)) * radius;
    now = stroked(now, s % 2 ? Method::smudge : Method::tug, along(from, to, radius));
    if (s % 20 != 19) continue;
    Surface surface(false);
    surface.update(now);
    const TopologyReport report = checkTopology(surface.toMesh());
    EXPECT_TRUE(report.closed()) << "seed " << seed << " stroke " << s;
    EXPECT_EQ(report.bodies, 1u) << "seed " << seed << " stroke " << s;
    store->collect();
  }
}

// A stroke back and forth that begins anew on the way: the same on any count of threads and however published, and the
// clay stays whole.
TEST(Warping, ALongStrokeIsTheSameOnAnyCountOfThreads) {
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d::Zero(), 40);
  for (const Method method : {Method::tug, Method::pinch}) {
    std::vector<uint64_t> hashes;
    for (const int threads : {1, 3}) {
      BrushStroke stroke(base, Brush::of(method), {}, threads);
      int stamps = 0;
      for (int n = 0; n < 4; ++n) {
        // The way back runs beside the way there, so that not all is undone.
        const Vec3d from(70, -25 + n, 4 * n), to(74, 25, 4 * n);
        for (const Stamp& each : n % 2 ? along(to, from, 14) : along(from, to, 14)) {
          stroke.apply(each);
          if (threads > 1 && ++stamps % 3 == 0) (void)stroke.publish();
        }
      }
      const Version after = stroke.finish();
      hashes.push_back(after.hash());
      EXPECT_NE(after.hash(), base.hash());
      Surface surface(false);
      surface.update(after);
      EXPECT_TRUE(checkTopology(surface.toMesh()).closed()) << static_cast<int>(method);
    }
    EXPECT_EQ(hashes[0], hashes[1]) << static_cast<int>(method);
  }
}

// Stamps of a large tip that are computed together look for bricks by cubes, and find all that change: the same clay as
// where each is computed at once.
TEST(Warping, LargeStampsTogetherLeaveTheClayThatTheyLeaveAlone) {
  const Version base = makeSphere(Store::make(), Grid{}, Vec3d(-16, 0, 0), 45);  // to 58 voxels: a region ends at 64
  for (const Method method : kWarps) {
    // Out of the clay, but a crease, which goes by the surface under its tip.
    const Vec3d to = method == Method::crease ? Vec3d(60, 18, -5) : Vec3d(96, 6, -5);
    const auto leave = [&](double together) {
      auto brush = std::make_shared<Brush>(*Brush::of(method));
      brush->quality.together = together;
      BrushStroke stroke(base, brush);
      for (const Stamp& each : along({54, -20, 5}, to, 64)) stroke.apply(each);
      return stroke.finish();
    };
    const Version alone = leave(0), together = leave(48);
    Sampler one(alone), other(together);
    double worst = 0;
    uint64_t near = 0, moved = 0;
    Sampler start(base);
    for (const Version* each : {&alone, &together})
      each->forEachBrick([&](const Brick& brick) {
        for (int i = 0; i < kBrickVoxels; ++i) {
          if (!(std::abs(brick.phi(i)) < 1)) continue;
          const Coord c = brick.coord * kBrickEdge + Coord{i >> 6, (i >> 3) & 7, i & 7};
          const double apart = std::abs(one.voxel(c) - other.voxel(c));
          worst = std::max(worst, apart);
          ++near;
          moved += std::abs(one.voxel(c) - start.voxel(c)) > 0.5f;
        }
      });
    std::printf("method %d: %.4f voxel apart at most, %llu of %llu voxels moved\n", static_cast<int>(method), worst,
                static_cast<unsigned long long>(moved), static_cast<unsigned long long>(near));
    // Under a crease the surface is that of the last bricks.
    EXPECT_LE(worst, method == Method::crease ? 0.4 : 0.01) << static_cast<int>(method);
    EXPECT_GT(moved, near / 100) << static_cast<int>(method);
    Surface surface(false);
    surface.update(together);
    EXPECT_TRUE(checkTopology(surface.toMesh()).closed()) << static_cast<int>(method);
  }
}

// Stamps that begin where there is no clay do nothing, and the stroke goes on.
TEST(Warping, StampsInTheAirDoNothing) {
  const Version base = sphere(Store::make());
  for (const Method method : kWarps) EXPECT_EQ(stroked(base, method, along({200, 0, 0}, {260, 0, 0}, 12)), base);
}

}  // namespace
}  // namespace argil::clay
