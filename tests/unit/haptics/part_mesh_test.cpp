// A mesh as something to touch: what it refuses, how it feels at creases, what a search costs.

#include "haptics/scene/part_mesh.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "haptics/analysis/touch_bench.h"
#include "haptics/contact/ball_contact.h"
#include "haptics/scene/touchable_part.h"
#include "haptics/threads/sample_ring.h"
#include "realtime_trap.h"
#include "tests/support/mesh_samples.h"

namespace argil::haptics {
namespace {

using samples::cube;
using samples::errorOf;
using testing::RealtimeTrap;

double angleDeg(const Vec3d& a, const Vec3d& b) {
  return std::atan2(a.cross(b).norm(), std::abs(a.dot(b))) * 180 / M_PI;
}

// The normal that is felt above `p`.
Vec3d feltNormal(const PartMesh& mesh, const Vec3d& p) {
  const PartMesh::Hit hit = mesh.nearest(p, 1e3, PartMesh::kNone);
  return mesh.normal(hit.triangle, hit.point);
}

TEST(PartMesh, RefusesWhatCannotBeTouched) {
  EXPECT_NE(errorOf([] { PartMesh{clay::TriangleMesh()}; }).find("without triangles"), std::string::npos);
  for (const double bad : {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity(), 2e9}) {
    clay::TriangleMesh mesh = cube();
    mesh.positions[3].y() = bad;
    EXPECT_NE(errorOf([&] { PartMesh{mesh}; }).find("vertex 3"), std::string::npos);
  }
  clay::TriangleMesh mesh = cube();
  mesh.triangles[2][1] = 8;
  EXPECT_NE(errorOf([&] { PartMesh{mesh}; }).find("names vertex 8"), std::string::npos);
  // What no triangle uses does not matter.
  mesh = cube();
  mesh.positions.push_back(Vec3d::Constant(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_EQ(PartMesh(mesh).triangleCount(), 12u);
}

TEST(PartMesh, StopsWhenItsJobIsCancelled) {
  Job job;
  job.cancel();
  EXPECT_THROW(PartMesh(cube(), &job), Cancelled);
}

TEST(PartMesh, TouchesTrianglesThatAreSegmentsOrPoints) {
  clay::TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {10, 0, 0}, {4, 0, 0}, {20, 5, 0}};
  mesh.triangles = {{0, 1, 2}, {3, 3, 3}, {0, 1, 1}};
  const PartMesh part(mesh);
  const PartMesh::Hit segment = part.nearest({7, 3, 4}, 100, PartMesh::kNone);
  EXPECT_LT((segment.point - Vec3d(7, 0, 0)).norm(), 1e-5);
  EXPECT_NEAR(segment.distance, 5, 1e-5);
  const PartMesh::Hit point = part.nearest({20, 5, 2}, 100, segment.triangle);
  EXPECT_LT((point.point - Vec3d(20, 5, 0)).norm(), 1e-5);
  EXPECT_TRUE(part.normal(point.triangle, point.point).isZero());
}

TEST(PartMesh, FindsNothingBeyondTheReachWhateverTheHint) {
  const PartMesh part(cube(5));
  const PartMesh::Hit far = part.nearest({9, 0, 0}, 3.9, 0);
  EXPECT_EQ(far.triangle, PartMesh::kNone);
  EXPECT_EQ(far.distance, 3.9);
  for (uint32_t hint = 0; hint < 14; ++hint) {
    const PartMesh::Hit hit = part.nearest({9, 0, 0}, 4.1, hint);
    ASSERT_NE(hit.triangle, PartMesh::kNone);
    EXPECT_NEAR(hit.distance, 4, 1e-5);
    EXPECT_LT((hit.point - Vec3d(5, 0, 0)).norm(), 1e-5);
  }
}

TEST(PartMesh, LosesNothingFarFromZero) {
  const Vec3d offset(1e6, -1e6, 1e6);
  clay::TriangleMesh far = icosphere(1, 3);
  const PartMesh here(far);
  for (Vec3d& p : far.positions) p += offset;
  const PartMesh there(far);
  std::mt19937 random(3);
  std::uniform_real_distribution<double> place(-2, 2);
  double worst = 0;
  for (int i = 0; i < 1000; ++i) {
    const Vec3d p(place(random), place(random), place(random));
    worst = std::max(worst, std::abs(here.nearest(p, 10, PartMesh::kNone).distance -
                                     there.nearest(p + offset, 10, PartMesh::kNone).distance));
  }
  // A double at 10^6 mm has steps of 1.2e-10 mm; the middle of the box moves with them, and then which floats are
  // nearest.
  EXPECT_LT(worst, 3e-7);
}

TEST(PartMesh, ACreaseIsACreaseAndAFlatFaceIsFlat) {
  const PartMesh part(cube(5));
  EXPECT_LT(angleDeg(feltNormal(part, {8, 1, 2}), Vec3d::UnitX()), 0.005);
  EXPECT_LT(angleDeg(feltNormal(part, {8, 4.99, 2}), Vec3d::UnitX()), 0.005) << "a crease shades into its faces";
  EXPECT_LT(angleDeg(feltNormal(part, {8, 2, 2}), Vec3d::UnitX()), 0.005) << "the diagonal of a flat face";
  EXPECT_TRUE(feltNormal(part, {8, 8, 1}).isZero()) << "an edge of 90°";
  EXPECT_TRUE(feltNormal(part, {8, 8, 8}).isZero()) << "a corner";
}

TEST(PartMesh, FlippedFacesAndRepeatedVerticesShadeAsIfTheyWereNot) {
  const clay::TriangleMesh whole = icosphere(10, 3);
  clay::TriangleMesh soup;
  std::mt19937 random(5);
  for (const auto& triangle : whole.triangles) {
    const auto first = static_cast<uint32_t>(soup.positions.size());
    for (const uint32_t v : triangle) soup.positions.push_back(whole.positions[v]);
    soup.triangles.push_back({first, first + 1, first + 2});
    if (random() % 2) std::swap(soup.triangles.back()[0], soup.triangles.back()[1]);
  }
  const PartMesh smooth(whole), turned(soup);
  std::normal_distribution<double> normal;
  for (int i = 0; i < 2000; ++i) {
    const Vec3d p = 12 * Vec3d(normal(random), normal(random), normal(random)).normalized();
    const Vec3d felt = feltNormal(smooth, p), foot = smooth.nearest(p, 1e3, PartMesh::kNone).point;
    // Facets of 1280 triangles stand up to 4.6° off the sphere.
    ASSERT_LT(angleDeg(felt, foot), 0.3);
    ASSERT_LT(angleDeg(felt, feltNormal(turned, p)), 0.01);
  }
}

TEST(PartMesh, ASheetFoldedOntoItselfIsNotOneSmoothSurface) {
  clay::TriangleMesh mesh;
  mesh.positions = {{0, 0, 0}, {10, 0, 0}, {5, 10, 0}, {5, 10.5, 0.2}};
  mesh.triangles = {{0, 1, 2}, {1, 0, 3}};
  EXPECT_TRUE(feltNormal(PartMesh(mesh), {5, -3, 0}).isZero());
}

TEST(PartMesh, AFanOfManyTrianglesIsShadedInNoTime) {
  clay::TriangleMesh mesh;
  constexpr uint32_t kSpokes = 20000;
  mesh.positions.push_back(Vec3d(0, 0, 1));
  for (uint32_t i = 0; i < kSpokes; ++i)
    mesh.positions.push_back(50 * Vec3d(std::cos(2 * M_PI * i / kSpokes), std::sin(2 * M_PI * i / kSpokes), 0));
  for (uint32_t i = 0; i < kSpokes; ++i) mesh.triangles.push_back({0, 1 + i, 1 + (i + 1) % kSpokes});
  const PartMesh part(mesh);
  EXPECT_LT(angleDeg(feltNormal(part, {0, 0, 4}), Vec3d::UnitZ()), 0.01);
}

TEST(PartMesh, DepthIsBoundedForTheWorstOfMeshes) {
  // Triangles that halve in size towards a corner: every split takes one off. And many at one place: no split tells
  // them apart.
  clay::TriangleMesh mesh;
  for (int i = 0; i < 2000; ++i) {
    const double at = std::ldexp(1000.0, -(i % 100)), size = 0.1 * at;
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(), {{at, 0, 0}, {at + size, 0, 0}, {at, size, 0}});
    mesh.triangles.push_back({first, first + 1, first + 2});
  }
  const PartMesh part(mesh);
  EXPECT_NEAR(part.nearest({500, 0, 7}, 100, PartMesh::kNone).distance, 7, 1e-3);
  EXPECT_LT(part.nearest({-1, 0, 0}, 100, PartMesh::kNone).nodes, 1500u);
}

TEST(PartMesh, ABallInASocketOfItsOwnSizeIsAnsweredWithoutLookingAtAllOfIt) {
  const PartMesh part(icosphere(40, 6));
  const PartMesh::Hit hit = part.nearest({0.001, 0, 0}, 41, PartMesh::kNone);
  EXPECT_LT(hit.looked, 1500u) << "of " << part.triangleCount();
  EXPECT_NEAR(hit.distance, 40, 0.02);
}

// Order of growth: what is looked at, not time.
TEST(PartMesh, ASearchGrowsWithTheLogarithmOfTheTriangles) {
  const auto look = [](int level) {
    const PartMesh part(icosphere(40, level));
    double nodes = 0, triangles = 0;
    uint32_t hint = PartMesh::kNone;
    constexpr int kCalls = 2000;
    for (int i = 0; i < kCalls; ++i) {
      const double a = 0.0007 * i, tilt = 0.3 * std::sin(0.37 * a);
      const Vec3d p = 43 * Vec3d(std::cos(a) * std::cos(tilt), std::sin(a) * std::cos(tilt), std::sin(tilt));
      const PartMesh::Hit hit = part.nearest(p, 4, hint);
      hint = hit.triangle;
      nodes += hit.nodes;
      triangles += hit.looked;
    }
    std::printf("%8zu triangles: %.1f nodes and %.1f triangles a search\n", part.triangleCount(), nodes / kCalls,
                triangles / kCalls);
    return std::pair(nodes / kCalls, triangles / kCalls);
  };
  const auto small = look(3), large = look(6);
  // 64 times as many triangles: three more levels of four.
  EXPECT_LT(large.first, small.first + 15);
  EXPECT_LT(large.second, 1.5 * small.second + 5);
}

TEST(TouchablePart, BreaksNoRuleOfRealTime) {
#if defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "ThreadSanitizer touches pages of its own and delivers signals late: nothing can be trapped under it";
#endif
  Scene scene = partScene(40, 6, 3);
  scene.materials[0].staticFriction = scene.materials[0].dynamicFriction = 0.3;
  TouchablePart part;
  RealtimeTrap trap;
  double sum = 0;
  const auto glide = [&] {
    for (int i = 0; i < 20000; ++i) {
      const double a = 0.001 * i, height = 43 + 3 * std::sin(0.01 * i);
      const Vec3d p = height * Vec3d(std::cos(a), std::sin(a) * 0.8, std::sin(a) * 0.6);
      part.reset(scene.parts[0], 3);
      const Nearest n = part.nearest(p, 4, nullptr);
      sum += n.distance;
      if (n.found) sum += part.normal(n.point).x();
    }
  };
  // The contact that uses it, friction and all, pressed in by 1 mm half of the time.
  BallContact contact;
  int touching = 0;
  const auto press = [&] {
    for (int i = 0; i < 20000; ++i) {
      BallContact::Input input;
      const double a = 0.001 * i;
      input.hand = (43 + std::sin(0.01 * i)) * Vec3d(std::cos(a), std::sin(a) * 0.8, std::sin(a) * 0.6);
      touching += (contact.tick(scene, input).flags & kTouching) != 0;
    }
  };
  glide();
  press();
  trap.enter();
  glide();
  press();
  trap.leave();
  EXPECT_GT(sum, 0);
  EXPECT_GT(touching, 10000);
  if (RealtimeTrap::seesAllocationsAndLocks()) {
    EXPECT_EQ(trap.allocations, 0u);
    EXPECT_EQ(trap.locks, 0u);
  }
  EXPECT_EQ(trap.systemCalls, 0u);
#if !defined(__SANITIZE_ADDRESS__)
  EXPECT_EQ(trap.pageFaults, 0u);
#endif
}

TEST(TouchablePart, AnswersInTheWorldAndNoticesWhatIsNew) {
  Scene scene;
  Part part;
  part.mesh = std::make_shared<const PartMesh>(cube(5));
  part.pose.translation = {100, 0, 0};
  part.pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 4, Vec3d::UnitZ()));
  TouchablePart touchable;
  EXPECT_TRUE(touchable.reset(part, 3));
  EXPECT_FALSE(touchable.reset(part, 3));
  touchable.move(part.pose);
  // An edge of the cube points to -x now.
  const double edge = 100 - 5 * std::sqrt(2.0);
  const Nearest n = touchable.nearest({edge - 2, 0, 1}, 3, nullptr);
  ASSERT_TRUE(n.found);
  EXPECT_LT((n.point - Vec3d(edge, 0, 1)).norm(), 1e-5);
  EXPECT_NEAR(n.distance, 2, 1e-5);
  EXPECT_TRUE(touchable.normal(n.point).isZero());
  const Vec3d faceNormal = Vec3d(1, 1, 0).normalized();
  const Nearest face = touchable.nearest(Vec3d(100, 0, 1) + 7 * faceNormal, 3, nullptr);
  ASSERT_TRUE(face.found);
  EXPECT_LT(angleDeg(touchable.normal(face.point), faceNormal), 0.005);
  // From inside too the distance is to the nearest face, and positive.
  EXPECT_NEAR(touchable.nearest({100, 0, 4}, 3, nullptr).distance, 1, 1e-5);
  EXPECT_FALSE(touchable.nearest({100, 0, 0}, 3, nullptr).found);

  // Older answers are found again.
  const Nearest other = touchable.nearest(Vec3d(100, 0, 1) + 7 * Vec3d(1, -1, 0).normalized(), 3, nullptr);
  for (int i = 0; i < 30; ++i) (void)touchable.nearest(Vec3d(100, 0, 0.1 * i) - 7 * faceNormal, 3, nullptr);
  EXPECT_LT(angleDeg(touchable.normal(other.point), Vec3d(1, -1, 0)), 0.005);
  EXPECT_LT(angleDeg(touchable.normal(face.point), faceNormal), 0.005);

  // Moved, it is the same mesh, and what was found on it goes along.
  part.pose.translation.x() = 101;
  EXPECT_FALSE(touchable.reset(part, 3));
  touchable.move(part.pose);
  EXPECT_LT(angleDeg(touchable.normal(other.point + Vec3d::UnitX()), Vec3d(1, -1, 0)), 0.005);
  EXPECT_NEAR(touchable.nearest(Vec3d(101, 0, 1) + 7 * faceNormal, 3, nullptr).distance, 2, 1e-5);
  part.mesh = std::make_shared<const PartMesh>(cube(5));
  EXPECT_TRUE(touchable.reset(part, 3)) << "another mesh of the same shape";
}

// A quarter of a turn later another face is where one was found: its normal is that of what is there now.
TEST(TouchablePart, WhatWasFoundBeforeItTurnedIsNotTakenForWhatIsThereNow) {
  Part part;
  part.mesh = std::make_shared<const PartMesh>(cube(5));
  TouchablePart touchable;
  (void)touchable.reset(part, 3);
  touchable.move(part.pose);
  const Nearest found = touchable.nearest({7, 0.5, 1}, 3, nullptr);
  ASSERT_TRUE(found.found);
  EXPECT_GT(touchable.normal(found.point).x(), 0.999);
  part.pose.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(M_PI / 2, Vec3d::UnitZ()));
  touchable.move(part.pose);
  EXPECT_GT(touchable.normal(found.point).x(), 0.999) << "not that of an edge either";
  EXPECT_GT(touchable.normal(part.pose.rotation * found.point).y(), 0.999);
}

TEST(TouchablePart, TheNormalOfWhatItNeverFoundIsThatOfTheFaceThere) {
  Part part;
  part.mesh = std::make_shared<const PartMesh>(cube(5));
  TouchablePart touchable;
  (void)touchable.reset(part, 3);
  touchable.move(part.pose);
  ASSERT_TRUE(touchable.nearest({7, 0, 1}, 3, nullptr).found);
  EXPECT_LT(angleDeg(touchable.normal({5, 1, 0.5}), Vec3d::UnitX()), 0.005);
  EXPECT_LT(angleDeg(touchable.normal({1, 5, 0.5}), Vec3d::UnitY()), 0.005);
}

}  // namespace
}  // namespace argil::haptics
