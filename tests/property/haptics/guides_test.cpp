// Guides over many paths: wells give out no more than they hold.

#include "haptics/contact/guides.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>
#include <random>

namespace argil::haptics {
namespace {

constexpr uint32_t kSeed = 31;

// A closed path through `centre`'s neighbourhood: three harmonics of each axis.
struct Loop {
  std::array<Vec3d, 3> cosine, sine;
  Vec3d middle;
  [[nodiscard]] Vec3d at(double phase) const {
    Vec3d p = middle;
    for (size_t i = 0; i < 3; ++i)
      p += std::cos(2 * std::numbers::pi * phase * double(i + 1)) * cosine[i] +
           std::sin(2 * std::numbers::pi * phase * double(i + 1)) * sine[i];
    return p;
  }
};

struct Energy {
  double most = -1e9, sum = 0;  // Of a loop: given to the hand, N·mm.
  int loops = 0, rims = 0;
};

// Loops of 500 ticks, each run twice: the first time finds the state that the second begins with.
Energy run(const Guide& guide, int loops, double size) {
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal(0, 1);
  const auto vector = [&](double scale) {
    return Vec3d(scale * normal(random), scale * normal(random), scale * normal(random));
  };
  Scene scene;
  scene.guides = {guide};
  scene.check();
  const auto owned = std::make_unique<Guides>();
  Guides& guides = *owned;
  Contact::Input in;
  in.peakForceN = 3.3;
  Energy energy;
  for (int i = 0; i < loops; ++i) {
    Loop loop;
    loop.middle = vector(0.6 * size);
    for (size_t k = 0; k < 3; ++k) {
      loop.cosine[k] = vector(size / double(k + 1));
      loop.sine[k] = vector(size / double(k + 1));
    }
    constexpr int kTicks = 500;
    double given = 0;
    bool felt = false;
    Vec3d before = Vec3d::Zero();
    for (int tick = 0; tick <= 2 * kTicks; ++tick) {
      const Vec3d last = in.hand;
      in.hand = loop.at(tick / double(kTicks));
      guides.begin(scene, in, in.hand, Vec3d::Zero());
      // Mean of both ends: what the guide gives, without what holding a force for a tick adds to any spring.
      if (tick > kTicks) given += 0.5 * (before + guides.force()).dot(in.hand - last);
      before = guides.force();
      if (tick > kTicks && felt != !before.isZero(0)) ++energy.rims;
      felt = !before.isZero(0);
    }
    energy.most = std::max(energy.most, given);
    energy.sum += given;
    ++energy.loops;
  }
  return energy;
}

TEST(GuidesEnergy, WellsGiveOutNoMoreThanTheyHold) {
  std::vector<Vec3d> wave;
  for (int i = 0; i <= 200; ++i) wave.push_back({i * 0.2 - 20, 5 * std::sin(i * 0.05), 2 * std::cos(i * 0.03)});
  const WellShape shape{8, 1};
  const std::array<std::pair<const char*, Guide>, 4> wells{
      {{"a point", {1, WellAtPoints{{Vec3d::Zero()}, shape}, 0}},
       {"three points within reach of each other", {1, WellAtPoints{{{-4, 0, 0}, {4, 0, 0}, {0, 5, 0}}, shape}, 0}},
       {"a curve", {1, WellAtCurve{std::make_shared<Polyline>(wave), shape}, 0}},
       {"a plane", {1, WellAtPlane{{0, 0, 1}, {1, 2, 3}, shape}, 0}}}};
  const double depth = wellDepthNmm(shape, shape.forceN);
  for (const auto& [name, guide] : wells) {
    const Energy energy = run(guide, 2500, 6);
    std::printf(
        "seed %u, %s: %d loops through %d rims give out at most %.3f N·mm, %.2f on average; the well holds %.2f\n",
        kSeed, name, energy.loops, energy.rims, energy.most, energy.sum / energy.loops, depth);
    EXPECT_GT(energy.rims, 500) << name;
    EXPECT_LE(energy.most, 0.1 * depth) << name;
    EXPECT_LE(energy.sum, 0) << name;
  }
}

// Switched on at the rim and off in the middle is the most that can be had, once for each press of the button.
TEST(GuidesEnergy, AButtonGetsNoMoreThanTheDepth) {
  Scene scene;
  const WellShape shape{8, 1};
  scene.guides = {{1, WellAtPoints{{Vec3d::Zero()}, shape}, 1}};
  const auto owned = std::make_unique<Guides>();
  Guides& guides = *owned;
  Contact::Input in;
  in.peakForceN = 3.3;
  double given = 0;
  constexpr int kPresses = 50;
  Vec3d before = Vec3d::Zero();
  for (int tick = 0; tick < kPresses * 1000; ++tick) {
    const double phase = tick % 1000 / 1000.0;
    const Vec3d last = in.hand;
    in.hand = {5.5 * 0.5 * (1 + std::cos(2 * std::numbers::pi * phase)), 0, 0};
    in.buttons = phase < 0.5;
    guides.begin(scene, in, in.hand, Vec3d::Zero());
    if (tick) given += 0.5 * (before + guides.force()).dot(in.hand - last);
    before = guides.force();
  }
  std::printf("%.2f N·mm a press, the well holds %.2f\n", given / kPresses, wellDepthNmm(shape, shape.forceN));
  EXPECT_LE(given / kPresses, wellDepthNmm(shape, shape.forceN));
  EXPECT_GT(given, 0);
}

}  // namespace
}  // namespace argil::haptics
