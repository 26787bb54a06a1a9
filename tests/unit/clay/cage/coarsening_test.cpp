// What makes coarse quads of many cheaper, and changes nothing of them.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <thread>

#include "clay/cage/cage_maker.h"
#include "clay/cage/coarsen_quads.h"
#include "clay/cage/least_near.h"
#include "clay/cage/web_on_surface.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"

namespace argil::clay {
namespace {

// A block with a bore and a thin fin.
Version finned() {
  Grid grid;
  grid.voxelMm = 0.8;
  const auto block = [&](const Vec3d& at, const Vec3d& size) { return makeBlock(Store::make(), grid, at, size, 0); };
  const Version body =
      combine(block(Vec3d(0, 0, 0), Vec3d(30, 20, 10)), block(Vec3d(3, 0, 8), Vec3d(20, 1.6, 10)), Combination::join);
  return combine(body, makeCylinder(Store::make(), grid, Vec3d(-9, 0, 0), 4, 40), Combination::cut);
}

QuadMesh fineOf(const CageMaker& maker, const Version& version) {
  Surface surface(false, Grade::fine);
  surface.update(version);
  QuadMesh fine = quadsOf(surface);
  maker.creases().mark(fine, maker.tree());
  return fine;
}

TEST(SharedCoarsening, GivesToTheBitWhatOneAloneGives) {
  const Version version = finned();
  const CageMaker maker(version, 200, true, 1, WorkPart(nullptr));
  ASSERT_FALSE(maker.creases().empty());
  const QuadMesh fine = fineOf(maker, version);
  const WebGround ground = maker.ground(maker.sizes());
  const SharedCoarsening shared(fine, ground, 260, WorkPart(nullptr));
  EXPECT_EQ(shared.most(), 260u);
  struct Case {
    size_t most;
    Coarsening how;
    QuadMesh mesh = {};
  };
  std::vector<Case> cases{{260, {}}, {200, {.regular = true}}, {120, {}}, {200, {.between = true}}};
  std::vector<std::thread> threads;  // beside each other, as layouts are drawn
  for (Case& each : cases) threads.emplace_back([&] { each.mesh = shared.to(each.most, WorkPart(nullptr), each.how); });
  for (std::thread& each : threads) each.join();
  for (const Case& each : cases) {
    const QuadMesh alone = coarsened(fine, ground, each.most, WorkPart(nullptr), each.how);
    EXPECT_LE(alone.quads.size(), each.most);
    EXPECT_EQ(each.mesh.quads, alone.quads) << each.most;
    EXPECT_EQ(each.mesh.positions, alone.positions) << each.most;
    EXPECT_EQ(each.mesh.creases, alone.creases) << each.most;
  }
}

// What is left keeps all that was known of it, in the same order, and can be joined on.
TEST(WebOnSurface, ForgetsWhatIsGoneAndNothingElse) {
  const Version version = finned();
  const CageMaker maker(version, 200, true, 1, WorkPart(nullptr));
  const WebGround ground = maker.ground(maker.sizes());
  WebOnSurface on(fineOf(maker, version), ground);
  QuadWeb& web = on.web();
  std::mt19937 random(11);
  const auto joinSome = [&](int count) {
    int joined = 0;
    for (int i = 0; i < 20000 && joined < count; ++i) {
      const auto f = static_cast<uint32_t>(random() % web.quads());
      const int corner = int(random() % 2);
      if (!web.isThere(f) || !web.gainOfCollapse(f, corner)) continue;
      (void)web.collapse(f, corner);
      ++joined;
    }
    EXPECT_EQ(joined, count);
  };
  joinSome(300);
  const QuadMesh before = web.mesh();
  ASSERT_LT(before.quads.size(), web.quads());
  struct Known {
    double shape, off, sizes;
    std::vector<uint32_t> around;
  };
  std::vector<uint32_t> joinedTo;
  const auto knownOf = [&](uint32_t v) {
    web.beside(v, joinedTo);
    double sizes = 0;
    for (const uint32_t each : joinedTo) sizes += on.sizeBetween(v, each);
    return Known{on.shapeAt(v), on.offAround(v, web.at(v)), sizes, web.around(v)};
  };
  std::vector<Known> was(web.vertices());
  for (uint32_t v = 0; v < web.vertices(); ++v)
    if (!web.around(v).empty()) was[v] = knownOf(v);
  const QuadWeb::Kept kept = on.forgetGone();
  ASSERT_EQ(kept.vertices.size(), before.positions.size());
  ASSERT_EQ(web.vertices(), before.positions.size());
  ASSERT_EQ(web.quads(), before.quads.size());
  EXPECT_EQ(web.count(), before.quads.size());
  EXPECT_TRUE(std::is_sorted(kept.quads.begin(), kept.quads.end()));
  const QuadMesh after = web.mesh();
  EXPECT_EQ(after.positions, before.positions);
  EXPECT_EQ(after.quads, before.quads);
  EXPECT_EQ(after.creases, before.creases);
  EXPECT_EQ(after.corners, before.corners);
  for (uint32_t v = 0; v < web.vertices(); ++v) {
    const Known now = knownOf(v), &then = was[kept.vertices[v]];
    EXPECT_EQ(now.shape, then.shape) << v;
    EXPECT_EQ(std::max(1.0, now.off), std::max(1.0, then.off)) << v;
    EXPECT_EQ(now.sizes, then.sizes) << v;
    ASSERT_EQ(now.around.size(), then.around.size());
    for (size_t i = 0; i < now.around.size(); ++i) EXPECT_EQ(kept.quads[now.around[i]], then.around[i]) << v;
  }
  joinSome(100);
}

// Whatever was drawn before, in whatever order, and after sizes have changed.
TEST(CageMaker, MakesTheSameAfterOtherCounts) {
  const Version version = finned();
  const auto made = [&](const std::vector<size_t>& counts, bool refined) {
    CageMaker maker(version, 150, true, 1, WorkPart(nullptr));
    QuadMesh last;
    for (const size_t each : counts) last = maker.make(WorkPart(nullptr), each).mesh;
    if (!refined) return last;
    std::vector<float> off(maker.surface().positions.size(), 0.01f);
    std::fill_n(off.begin(), off.size() / 8, 1.0f);
    maker.refine(off);
    return maker.make(WorkPart(nullptr)).mesh;
  };
  EXPECT_EQ(made({150}, false).positions, made({290, 150}, false).positions);
  EXPECT_GT(made({500}, false).quads.size(), 450u) << "more than what is shared";
  EXPECT_EQ(made({}, true).positions, made({150}, true).positions);
  EXPECT_NE(made({}, true).positions, made({150}, false).positions);
}

TEST(LeastNear, IsBetweenWhatLiesWithinTheReachAndWithinTwice) {
  std::mt19937 random(7);
  std::uniform_real_distribution<double> place(-20, 20), value(0.1, 9);
  for (const double reach : {0.5, 3.0, 100.0}) {
    std::vector<Vec3d> places;
    std::vector<float> values;
    for (int i = 0; i < 400; ++i) {
      places.emplace_back(place(random), 0.2 * place(random), 0.1 * place(random));
      values.push_back(static_cast<float>(value(random)));
    }
    const std::vector<float> out = leastNear(places, values, reach);
    ASSERT_EQ(out.size(), places.size());
    for (size_t i = 0; i < places.size(); ++i) {
      float within = values[i], withinTwice = values[i];
      for (size_t k = 0; k < places.size(); ++k) {
        const double away = (places[k] - places[i]).cwiseAbs().maxCoeff();
        if (away <= reach) within = std::min(within, values[k]);
        if (away <= 2 * reach) withinTwice = std::min(withinTwice, values[k]);
      }
      EXPECT_LE(out[i], within);
      EXPECT_GE(out[i], withinTwice);
    }
  }
}

TEST(NearestTriangle, NearEnoughIsAsNearAsThatOrTheNearest) {
  const Version version = finned();
  const CageMaker maker(version, 200, true, 1, WorkPart(nullptr));
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-18, 18);
  uint32_t hint = UINT32_MAX;
  int others = 0;
  for (int i = 0; i < 3000; ++i) {
    const Vec3d p(place(random), place(random), place(random));
    const double enough = i % 3 == 0 ? 0 : 0.7 * std::abs(place(random));
    const NearestTriangle::Hit nearest = maker.tree().nearest(p), hit = maker.tree().nearEnough(p, enough, hint);
    hint = hit.triangle;
    EXPECT_EQ(maker.tree().squaredTo(hit.triangle, p), hit.squared);
    if (hit.squared > enough * enough) {
      EXPECT_EQ(hit.squared, nearest.squared) << i;
    }
    others += hit.squared > nearest.squared;
  }
  EXPECT_GT(others, 100) << "nothing was saved";
}

// Against the formula in the header, where thin and thick walls lie side by side: what is more than
// allowed is told to the bit, and what is less is never more, wherever the vertex was before.
TEST(WebOnSurface, TellsWhatLiesTooFarOffWhereverItWasBefore) {
  const Version version = finned();
  const CageMaker maker(version, 200, true, 1, WorkPart(nullptr));
  const WebGround ground = maker.ground(maker.sizes());
  WebOnSurface on(maker.make(WorkPart(nullptr)).mesh, ground);
  const QuadWeb& web = on.web();
  const auto off = [&](const Vec3d& p, double length) {
    const NearestTriangle::Hit hit = maker.tree().nearest(p);
    double wall = HUGE_VAL, size = 0;
    for (const uint32_t v : maker.tree().corners(hit.triangle)) {
      wall = std::min(wall, double(ground.walls[v]));
      size += double(ground.sizes[v]) / 3;
    }
    return std::sqrt(hit.squared) / std::min(0.35 * wall, std::max(ground.finest, 0.2 * std::min(length, 2 * size)));
  };
  std::mt19937 random(5);
  std::normal_distribution<double> away;
  int over = 0, under = 0;
  for (int i = 0; i < 4000; ++i) {
    const auto v = static_cast<uint32_t>(random() % web.vertices());
    if (web.around(v).empty()) continue;
    const double scale = std::pow(10, -1.5 * double(i % 7) / 6);
    const Vec3d to = web.at(v) + 2 * scale * Vec3d(away(random), away(random), away(random));
    double most = 0;
    for (const uint32_t f : web.around(v)) {
      const auto& q = web.quad(f);
      const auto s = size_t(std::find(q.begin(), q.end(), v) - q.begin());
      const Vec3d &next = web.at(q[(s + 1) & 3]), &far = web.at(q[(s + 2) & 3]), &last = web.at(q[(s + 3) & 3]);
      most = std::max({most, off(0.5 * (to + next), (to - next).norm()),
                       off(0.25 * (to + next + far + last), 0.5 * ((to - far).norm() + (next - last).norm()))});
    }
    const double told = on.offAround(v, to);
    if (most > 1 + 1e-9) {
      EXPECT_NEAR(told, most, 1e-9 * most) << i;
    } else if (most < 1 - 1e-9) {
      EXPECT_LE(told, 1) << i;
    }
    ++(most > 1 ? over : under);
  }
  EXPECT_GT(over, 500);
  EXPECT_GT(under, 500);
}

}  // namespace
}  // namespace argil::clay
