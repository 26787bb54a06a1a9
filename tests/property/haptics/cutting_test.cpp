// Cutting: depth under a constant force, the same force before and after the edit arrives, no kick, no runaway.

#include "haptics/contact/cutting.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <chrono>
#include <deque>
#include <memory>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay_fields.h"
#include "haptics/contact/ball_contact.h"
#include "haptics/threads/sample_ring.h"

namespace argil::haptics {
namespace {

using namespace testing;

constexpr double kVoxel = 0.5;
constexpr double kStiffness = 1.26;
constexpr double kPeriod = 1e-3;

/// The session in small: carves what the contact says, `delay` ticks later, a version each `every` ticks.
class Sculptor {
 public:
  Sculptor(const clay::Version& start, double radiusMm, int delay, int every)
      : stroke_(std::make_unique<clay::BrushStroke>(start, clay::Brush::of(clay::Method::carve))),
        delay_(delay),
        every_(every) {
    scene_.pieces.push_back({start, Pose(), 0});
    scene_.tool.radiusMm = radiusMm;
    scene_.tool.work = Work::cut;
  }
  Scene& scene() { return scene_; }
  void sample(uint64_t index, const BallContact::Output& out) {
    if (out.flags & kCutting) waiting_.push_back({index, out.cutPoint});
    if (index % static_cast<uint64_t>(every_) != 0) return;
    bool any = false;
    while (!waiting_.empty() && waiting_.front().first + static_cast<uint64_t>(delay_) <= index) {
      const auto [i, at] = waiting_.front();
      waiting_.pop_front();
      const Vec3d voxel = scene_.pieces[0].version.grid().toVoxel(at);
      if (!have_ || (voxel - last_).norm() > 0.02) {
        clay::Stamp stamp;
        stamp.a = have_ ? last_ : voxel;
        stamp.b = last_ = voxel;
        stamp.radius = scene_.tool.radiusMm / kVoxel;
        stroke_->apply(stamp);
        have_ = any = true;
      }
      scene_.samplesApplied = i + 1;
    }
    if (any) scene_.pieces[0].version = stroke_->publish();
  }

 private:
  std::unique_ptr<clay::BrushStroke> stroke_;
  Scene scene_;
  int delay_, every_;
  std::deque<std::pair<uint64_t, Vec3d>> waiting_;
  Vec3d last_ = Vec3d::Zero();
  bool have_ = false;
};

BallContact::Input inputAt(const Vec3d& hand, uint64_t index, bool operate) {
  BallContact::Input in;
  in.hand = hand;
  in.topStiffnessNmm = kStiffness;
  in.peakForceN = 1e3;
  in.operate = operate;
  in.sampleIndex = index;
  in.periodS = kPeriod;
  return in;
}

/// Presses a ball with a constant force on a block from above until it rests; how deep its bottom is below the top, mm.
double restUnder(double forceN, double radiusMm, double hardness, int delay) {
  clay::Grid grid;
  grid.voxelMm = kVoxel;
  const clay::Version block = clay::makeBlock(clay::Store::make(), grid, {0.13, 0.07, -10.1}, {50, 50, 20}, 0);
  const double top = -0.1;
  Sculptor sculptor(block, radiusMm, delay, 5);
  sculptor.scene().materials[0].hardnessNmm2 = hardness;
  sculptor.scene().materials[0].stiffnessNmm = kStiffness;
  BallContact contact;
  Vec3d hand(0.2, -0.1, top + radiusMm + 0.05);
  BallContact::Output out;
  for (uint64_t i = 0; i < 2500; ++i) {
    out = contact.tick(sculptor.scene(), inputAt(hand, i, true));
    sculptor.sample(i, out);
    // A hand without mass or place of its own: a force against a damper.
    hand += (Vec3d(0, 0, -forceN) + out.force) / 0.02 * kPeriod;
  }
  EXPECT_NEAR(out.force.z(), forceN, 0.02 * forceN);
  EXPECT_LT(std::hypot(out.force.x(), out.force.y()), 0.05 * forceN);
  return top - (out.cutPoint.z() - radiusMm);
}

TEST(Cutting, AConstantForceRestsAtThePredictedDepth) {
  for (double radius : {2.0, 3.0, 6.0, 10.0})
    for (double hardness : {0.02, 0.05, 0.1, 0.3}) {
      const double predicted = 0.25 * radius;  // Deep enough for five per cent to be more than a tenth of a voxel.
      const double force = hardness * engagedArea(radius, predicted);
      EXPECT_NEAR(restingDepth(radius, hardness, force), predicted, 1e-9);
      for (int delay : {0, 20}) {
        const double depth = restUnder(force, radius, hardness, delay);
        std::printf("r %4.1f mm, hardness %.2f, %5.2f N, edits %2d ticks late: %.3f mm (predicted %.3f)\n", radius,
                    hardness, force, delay, depth, predicted);
        EXPECT_NEAR(depth, predicted, 0.05 * predicted) << radius << " " << hardness << " " << delay;
      }
    }
}

TEST(Cutting, FeelsTheSameHoweverLateTheEditComes) {
  // A groove at 40 mm/s with the hand 2 mm deep; forces of a run with edits at once and one with edits 20 ticks late.
  std::vector<std::vector<Vec3d>> forces;
  for (int delay : {0, 20}) {
    clay::Grid grid;
    grid.voxelMm = kVoxel;
    const clay::Version block = clay::makeBlock(clay::Store::make(), grid, {0, 0, -10.1}, {60, 40, 20}, 0);
    Sculptor sculptor(block, 3, delay, 5);
    sculptor.scene().materials[0].stiffnessNmm = kStiffness;
    BallContact contact;
    auto& run = forces.emplace_back();
    for (uint64_t i = 0; i < 1000; ++i) {
      const double t = double(i) * kPeriod;
      const Vec3d hand(-20 + 40 * t, 0.3, 3.0 - 4.0 * std::min(t, 0.5));
      const auto out = contact.tick(sculptor.scene(), inputAt(hand, i, true));
      sculptor.sample(i, out);
      run.push_back(out.force);
    }
  }
  double most = 0, jump = 0, worst = 0;
  for (size_t i = 1; i < forces[0].size(); ++i) {
    most = std::max(most, forces[0][i].norm());
    worst = std::max(worst, (forces[0][i] - forces[1][i]).norm());
    for (const auto& run : forces) jump = std::max(jump, (run[i] - run[i - 1]).norm());
  }
  std::printf("groove: force up to %.2f N, late edits differ by %.3f N at most, tick to tick %.3f N at most\n", most,
              worst, jump);
  EXPECT_GT(most, 0.3);
  EXPECT_LT(worst, 0.15 * most);
  EXPECT_LT(jump, 0.1 * most);
}

TEST(Cutting, LettingGoLeavesTheBallTouching) {
  // The button is let go while edits are still 20 ticks behind: nothing may push the ball out of clay that is already
  // gone.
  clay::Grid grid;
  grid.voxelMm = kVoxel;
  const clay::Version block = clay::makeBlock(clay::Store::make(), grid, {0, 0, -10.1}, {40, 40, 20}, 0);
  Sculptor sculptor(block, 3, 20, 5);
  sculptor.scene().materials[0].stiffnessNmm = kStiffness;
  BallContact contact;
  double before = 0, change = 0;
  bool left = false;
  for (uint64_t i = 0; i < 1500; ++i) {
    const double t = double(i) * kPeriod;
    const Vec3d hand(0.1, 0.2, 3.0 - 4.0 * std::min(t, 0.7));
    const auto out = contact.tick(sculptor.scene(), inputAt(hand, i, i < 900));
    sculptor.sample(i, out);
    if (i >= 900) {
      change = std::max(change, std::abs(out.force.norm() - before));
      left = left || (out.flags & kLeaving);
    }
    before = out.force.norm();
  }
  EXPECT_GT(before, 0.3);
  EXPECT_LT(change, 0.07 * before) << "a kick when the tool was let go";
  std::printf("let go: steepest change %.2f %% of the force in a tick%s\n", 100 * change / before,
              left ? ", moved out a little" : "");
}

TEST(Cutting, AreaAndDepthAreOfTheCap) {
  EXPECT_DOUBLE_EQ(engagedArea(3, 0), 0);
  EXPECT_NEAR(engagedArea(3, 1), 3.14159265358979 * 5, 1e-12);
  EXPECT_NEAR(engagedArea(3, 99), 3.14159265358979 * 9, 1e-12);
  // For a shallow cut h is near F / (2πrσ), as the methods say.
  EXPECT_NEAR(restingDepth(3, 0.05, 0.02) / (0.02 / (2 * 3.14159265358979 * 3 * 0.05)), 1, 0.01);
}

TEST(Cutting, CostOfATick) {
  clay::Grid grid;
  grid.voxelMm = kVoxel;
  const clay::Version block = clay::makeBlock(clay::Store::make(), grid, {0, 0, -20.1}, {100, 60, 40}, 0);
  for (double r : {3.0, 6.0, 12.0, 24.0}) {
    Sculptor sculptor(block, r * kVoxel, 5, 5);
    sculptor.scene().materials[0].stiffnessNmm = kStiffness;
    BallContact contact;
    std::vector<double> us;
    for (uint64_t i = 0; i < 2000; ++i) {
      const double t = double(i) * kPeriod;
      const Vec3d hand(-20 + 20 * t, 3 * std::sin(6 * t), r * kVoxel - 2.0 * std::min(t, 1.0));
      const auto begin = std::chrono::steady_clock::now();
      const auto out = contact.tick(sculptor.scene(), inputAt(hand, i, true));
      us.push_back(std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count());
      sculptor.sample(i, out);
    }
    std::sort(us.begin(), us.end());
    std::printf("cut, r %4.1f voxels: median %.2f us, p99 %.2f us, p99.9 %.2f us\n", r, us[us.size() / 2],
                us[us.size() * 99 / 100], us[us.size() * 999 / 1000]);
    EXPECT_LT(us[us.size() / 2], 1000);
  }
}

}  // namespace
}  // namespace argil::haptics
