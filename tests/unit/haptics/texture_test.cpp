// Textures: heights within their range, slopes that are their gradients, nothing that could alias; and the path over
// them.

#include "haptics/scene/texture.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "clay/base/error.h"
#include "haptics/contact/texture_path.h"
#include "realtime_trap.h"

namespace argil::haptics {
namespace {

constexpr uint32_t kSeed = 3;
constexpr double kPi = std::numbers::pi;

HeightMap image(int width, int height, double mmPerPixel, uint32_t seed) {
  HeightMap map;
  map.width = width;
  map.height = height;
  map.mmPerPixel = mmPerPixel;
  map.amplitudeMm = 0.1;
  std::mt19937 random(seed);
  std::uniform_real_distribution<float> grey(0, 1);
  for (int i = 0; i < width * height; ++i) map.grey.push_back(grey(random));
  return map;
}

struct Case {
  const char* name;
  Texture texture;
};
std::vector<Case> cases() {
  return {{"ridges", Texture(Ridges{0.7, 0.1, Vec3d(1, 0.4, 0.2)})},
          {"bumps", Texture(Bumps{0.9, 0.1})},
          {"grain", Texture(Grain{1.1, 0.1, 3, kSeed})},
          {"image", Texture(image(37, 20, 0.3, kSeed))}};
}

Vec3d randomNormal(std::mt19937& random) {
  std::normal_distribution<double> any;
  return Vec3d(any(random), any(random), any(random)).normalized();
}

TEST(Texture, SlopeIsTheGradientAlongTheSurface) {
  for (const Case& c : cases()) {
    std::mt19937 random(kSeed);
    std::uniform_real_distribution<double> spread(-20, 20);
    double worst = 0, lowest = 0, highest = -1, jump = 0;
    for (int i = 0; i < 5000; ++i) {
      const Vec3d at(spread(random), spread(random), spread(random)), n = randomNormal(random);
      const double finest = i % 3 ? 0.0 : 0.3;
      Vec3d slope;
      const double h = c.texture.height(at, n, finest, &slope);
      lowest = std::min(lowest, h);
      highest = std::max(highest, h);
      EXPECT_NEAR(slope.dot(n), 0, 1e-12) << c.name;
      const Vec3d along = n.unitOrthogonal();
      constexpr double kStep = 1e-5;
      const double up = c.texture.height(at + kStep * along, n, finest, nullptr),
                   down = c.texture.height(at - kStep * along, n, finest, nullptr);
      worst = std::max(worst, std::abs((up - down) / (2 * kStep) - slope.dot(along)));
      jump = std::max(jump, std::abs(up - h));
      // Turned a little: no seam where one projection gives way to another.
      const double turned = c.texture.height(at, (n + 1e-5 * along).normalized(), finest, nullptr);
      jump = std::max(jump, std::abs(turned - h));
    }
    EXPECT_LT(worst, 1e-3) << c.name;
    EXPECT_LT(jump, 1e-4 * c.texture.rangeMm()) << c.name;
    EXPECT_LE(highest, 1e-12) << c.name;
    EXPECT_GE(lowest, -c.texture.rangeMm() - 1e-12) << c.name;
    EXPECT_GT(highest - lowest, 0.3 * c.texture.rangeMm()) << c.name;
  }
}

// Whatever is rendered at a speed is at least as long as what that speed allows.
TEST(Texture, NothingShorterThanAskedForIsLeft) {
  for (const Case& c : cases()) {
    const Vec3d n = Vec3d(0.1, 0.2, 1).normalized();
    double before = 1e9;
    for (const double finest : {0.0, 0.2, 0.4, 0.8, 1.6, 3.2, 100.0}) {
      double sum = 0, sum2 = 0;
      constexpr int kPlaces = 4000;
      for (int i = 0; i < kPlaces; ++i) {
        const double h = c.texture.height(Vec3d(0.0173 * i, 0.011 * i, 0.3), n, finest, nullptr);
        sum += h;
        sum2 += h * h;
      }
      const double rms = std::sqrt(std::max(0.0, sum2 / kPlaces - sum * sum / kPlaces / kPlaces));
      EXPECT_LE(rms, before * 1.02) << c.name << finest;
      before = rms;
      if (finest == 100) {
        EXPECT_LT(rms, 1e-6) << c.name;
      }
    }
  }
}

TEST(Texture, AnImageKeepsItsHeightsAndItsMirrorsMeetSmoothly) {
  // A ramp along x: where the image ends it comes back.
  HeightMap map;
  map.width = 32;
  map.height = 4;
  map.mmPerPixel = 0.5;
  map.amplitudeMm = 1;
  for (int y = 0; y < 4; ++y)
    for (int x = 0; x < 32; ++x) map.grey.push_back(float(x) / 31);
  const Texture texture(map);
  const auto at = [&](double x) { return texture.height({x, 0.2, 0}, Vec3d::UnitZ(), 0, nullptr); };
  EXPECT_NEAR(at(8), -1, 1e-6);  // In the middle of its 16 mm.
  EXPECT_NEAR(at(4) - at(12), -8 * 2 / (31 * 0.5), 1e-5);
  double jump = 0;
  for (double x = -40; x < 40; x += 0.01) jump = std::max(jump, std::abs(at(x + 0.01) - at(x)));
  EXPECT_LT(jump, 0.01 * 2 / (31 * 0.5) * 1.01);
  EXPECT_NEAR(at(15.5), at(16.5), 1e-9);
  EXPECT_NEAR(texture.height({8, 0.2, 0}, Vec3d::UnitZ(), 1e3, nullptr), -1, 1e-6);
}

TEST(Texture, BadNumbersAreRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(Texture(Ridges{0, 0.1, Vec3d::UnitX()}), Error);
  EXPECT_THROW(Texture(Ridges{nan, 0.1, Vec3d::UnitX()}), Error);
  EXPECT_THROW(Texture(Ridges{1, 0.1, Vec3d::Zero()}), Error);
  EXPECT_THROW(Texture(Bumps{1, 11}), Error);
  EXPECT_THROW(Texture(Bumps{0, 0.1}), Error);
  EXPECT_THROW(Texture(Bumps{nan, 0.1}), Error);
  EXPECT_THROW(Texture(Bumps{1, nan}), Error);
  EXPECT_THROW(Texture(Grain{1, 0.1, 7, 1}), Error);
  HeightMap map = image(4, 4, 0.1, 1);
  map.grey[3] = std::numeric_limits<float>::quiet_NaN();
  EXPECT_THROW(Texture{map}, Error);
  map.grey.pop_back();
  EXPECT_THROW(Texture{map}, Error);
  const Texture ridges(Ridges{});
  EXPECT_TRUE(std::isfinite(ridges.height({1e300, -1e300, 0}, Vec3d::UnitZ(), 0, nullptr)));
}

// A flat surface at z = 0 under a ball of radius zero: the smooth proxy is above or below the hand.
struct Flat {
  Pose pose;
  const Texture* texture;
  TexturedPlane plane(const Vec3d& proxy) const { return {{Vec3d::UnitZ(), 0}, texture, &pose, proxy}; }
  TexturePath::Place tick(TexturePath& path, const Vec3d& hand) const {
    if (hand.z() >= 0) return path.advance(hand, hand, nullptr, 0);
    const Vec3d proxy(hand.x(), hand.y(), 0);
    const TexturedPlane p = plane(proxy);
    return path.advance(proxy, hand, &p, 1);
  }
};

// Rendered RMS along z, as a part of the full amplitude of a sine, at a speed across ridges of 0.2 mm, 1 kHz.
double rendered(double speedMms, double amplitude, double depth) {
  const Texture ridges(Ridges{0.2, amplitude, Vec3d::UnitX()});
  const Flat flat{Pose(), &ridges};
  TexturePath path;
  std::vector<double> force;
  for (int i = 0; i < 3000; ++i) {
    const double sink = std::min(1.0, i / 300.0);
    const auto place = flat.tick(path, {speedMms * 1e-3 * i, 0.1, 0.05 - sink * (depth + 0.05)});
    if (i >= 1000) force.push_back(place.stretch.z());
  }
  double sum = 0, sum2 = 0;
  for (const double f : force) {
    sum += f;
    sum2 += f * f;
  }
  const double mean = sum / double(force.size());
  return std::sqrt(std::max(0.0, sum2 / double(force.size()) - mean * mean)) / (amplitude / std::sqrt(2.0));
}

// What was touched before the hand rose is no way that it came by.
TEST(TexturePath, BeginsAnewWithEachTouch) {
  const Texture ridges(Ridges{0.8, 0.1, Vec3d::UnitX()});
  const Flat flat{Pose(), &ridges};
  TexturePath fresh, again;
  for (int i = 0; i < 100; ++i) (void)flat.tick(again, {0.05 * i, 0, -0.3});
  (void)flat.tick(again, {5, 0, 1});
  for (int i = 0; i < 200; ++i) {
    const Vec3d hand(40.2 + 0.02 * i, 0, -0.005 * i);
    if (hand.z() >= 0) continue;
    const auto a = flat.tick(again, hand), b = flat.tick(fresh, hand);
    ASSERT_EQ(a.stretch, b.stretch) << i;
    ASSERT_EQ(a.proxy, b.proxy) << i;
  }
}

TEST(TexturePath, FullAtAHandsSpeedAndGoneWhereItWouldAlias) {
  for (const double amplitude : {0.005, 0.02, 0.05}) {
    const double slow = rendered(20, amplitude, 1), fast = rendered(100, amplitude, 1),
                 between = rendered(53, amplitude, 1);
    std::printf("ridges of 0.2 mm, amplitude %.3f mm: %.4f of it at 20 mm/s, %.4f at 53, %.4f at 100\n", amplitude,
                slow, between, fast);
    EXPECT_NEAR(slow, 1, 0.05) << amplitude;
    EXPECT_LE(fast, 0.02) << amplitude;
    EXPECT_LT(between, 0.9) << amplitude;
  }
}

// A bump that is narrower than the way of a tick is still felt, whatever the speed and wherever the ticks fall: as much
// of it.
TEST(TexturePath, NoDetailOnThePathIsSkipped) {
  HeightMap map;
  map.width = 256;
  map.height = 2;
  map.mmPerPixel = 0.05;
  map.amplitudeMm = 0.1;
  map.grey.assign(512, 0.0f);
  for (int y = 0; y < 2; ++y)
    for (int x = 126; x < 130; ++x) map.grey[size_t(256 * y + x)] = 1;  // 0.2 mm wide, 0.2 mm high, at 6.4 mm.
  const Texture bump(map);
  const Flat flat{Pose(), &bump};
  for (const double mms : {5.0, 30.0, 100.0, 250.0, 400.0})
    for (const double phase : {0.0, 0.25, 0.5, 0.75}) {
      TexturePath path;
      const double step = mms * 1e-3;
      double area = 0, x = 0.4;
      for (int i = 0; i < 100; ++i) flat.tick(path, {x, 0.02, -0.01 * i});  // Pressed in before.
      for (; x < 12.4; x += step) {
        const double raised = flat.tick(path, {x + phase * step, 0.02, -1}).proxy.z() + bump.rangeMm();
        if (x > 1) area += raised * step;
      }
      EXPECT_NEAR(area, 0.2 * 0.2, 0.2 * 0.04) << mms << " mm/s " << phase;
    }
}

TEST(TexturePath, TheForceIsTiltedByTheSlope) {
  const Texture ridges(Ridges{2, 0.05, Vec3d::UnitX()});
  const Flat flat{Pose(), &ridges};
  TexturePath path;
  for (int i = 0; i <= 4000; ++i) {
    const Vec3d hand(i * 0.0005, 0, -std::min(1.0, i / 100.0));
    const auto place = flat.tick(path, hand);
    if (i < 400) continue;
    const double phase = kPi * hand.x(), h = 0.05 * (std::cos(phase) - 1), slope = -0.05 * kPi * std::sin(phase);
    EXPECT_NEAR(place.stretch.z(), 1 + h, 1e-4);
    EXPECT_NEAR(place.stretch.x(), -(1 + h) * slope, 1e-4);
    EXPECT_NEAR(place.proxy.z(), h, 1e-4);
  }
}

// Quasi-static closed loops: the force has a potential.
TEST(TexturePath, ClosedLoopsGiveNothing) {
  for (const Case& c : cases()) {
    const Flat flat{Pose{Vec3d(1, 2, 3), Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()))},
                    &c.texture};
    TexturePath path;
    constexpr int kSteps = 40'000;
    Vec3d before = Vec3d::Zero(), force = Vec3d::Zero();
    double out = 0, moved = 0;
    for (int loop = 0; loop < 2; ++loop)
      for (int i = 0; i <= kSteps; ++i) {
        const double a = 2 * kPi * i / kSteps;
        const Vec3d hand(2 * std::cos(a), 1.5 * std::sin(a), -0.8 + 0.2 * std::sin(3 * a));
        const auto place = flat.tick(path, hand);
        if (loop) {
          const double work = 0.5 * (force + place.stretch).dot(hand - before);
          out += work;
          moved += std::abs(work);
        }
        before = hand;
        force = place.stretch;
      }
    EXPECT_LT(std::abs(out), 2e-3 * moved) << c.name;
    EXPECT_GT(moved, 0.1) << c.name;
  }
}

// Any motion, any speed, friction that holds the proxy back: at no moment of a contact has the texture given more than
// the smooth contact did, what that still holds, and what it takes to climb the texture once; and that comes back but
// slowly.
TEST(TexturePath, NeverOwesMoreThanToClimbItOnce) {
  std::printf("seed %u\n", kSeed);
  for (const Case& c : cases()) {
    const Flat flat{Pose(), &c.texture};
    std::mt19937 random(kSeed);
    std::normal_distribution<double> any;
    double worst = 0, lost = 0, passed = 0;
    int contacts = 0;
    for (int run = 0; run < 300; ++run) {
      TexturePath path;
      const double lively = std::pow(10.0, -3.5 + 0.007 * run);  // Pushes up to 40 m/s².
      const bool friction = run % 2;
      Vec3d hand(0, 0, 0.1), speed = Vec3d::Zero(), proxy = hand, smoothForce = Vec3d::Zero(), force = Vec3d::Zero();
      // Energy given by the texture less that by the smooth contact; all that passed.
      double more = 0, paid = 0, mayOwe = 0;
      for (int i = 0; i < 1000; ++i) {
        speed =
            0.9 * speed + lively * Vec3d(any(random), any(random), any(random)) + 0.01 * Vec3d(0, 0, -0.5 - hand.z());
        more += (force - smoothForce).dot(speed);
        paid += std::abs(force.dot(speed));
        hand += speed;
        if (hand.z() >= 0) {
          lost -= more;
          passed += paid;
          more = paid = mayOwe = 0;
          proxy = hand;
          path.advance(proxy, hand, nullptr, 0);
          smoothForce = force = Vec3d::Zero();
          ++contacts;
          continue;
        }
        Vec3d foot(hand.x(), hand.y(), 0);
        if (friction && proxy.z() <= 0) {
          const Vec3d back(proxy.x() - foot.x(), proxy.y() - foot.y(), 0);
          const double allowed = -0.4 * hand.z();
          foot += back.norm() > allowed ? Vec3d(back * (allowed / back.norm())) : back;
        }
        proxy = foot;
        const TexturedPlane plane = flat.plane(proxy);
        smoothForce = proxy - hand;
        force = path.advance(proxy, hand, &plane, 1).stretch;
        const double climb = c.texture.rangeMm() * smoothForce.norm();
        mayOwe = std::max(mayOwe, climb) + 0.002 * climb;
        worst = std::max(worst, (more - 0.5 * smoothForce.squaredNorm()) / mayOwe);
      }
    }
    std::printf("%s: %d contacts; at most %.2f of what may be owed; %.4f of what passed was lost\n", c.name, contacts,
                worst, lost / passed);
    EXPECT_LT(worst, 1.1) << c.name;
    EXPECT_GT(lost, 0) << c.name;
  }
}

// Two walls of a groove, each with its own texture: each plane is displaced by its own.
TEST(TexturePath, EachPlaneWearsItsOwnTexture) {
  const Texture deep(Ridges{1, 0.2, Vec3d::UnitY()}), shallow(Ridges{3, 0.1, Vec3d::UnitY()});
  const Pose pose;
  TexturePath path;
  for (int i = 0; i <= 3000; ++i) {
    const double y = i * 0.001, d = std::min(1.0, i * 0.005);
    const Vec3d hand(-d, y, -d), proxy(0, y, 0);
    const TexturedPlane planes[] = {{{Vec3d::UnitX(), 0}, &deep, &pose, proxy},
                                    {{Vec3d::UnitZ(), 0}, &shallow, &pose, proxy}};
    const auto place = path.advance(proxy, hand, planes, 2);
    if (i < 1000) continue;
    EXPECT_NEAR(place.stretch.x(), 1 + 0.2 * (std::cos(2 * kPi * y) - 1), 1e-3);
    EXPECT_NEAR(place.stretch.z(), 1 + 0.1 * (std::cos(2 * kPi * y / 3) - 1), 1e-3);
    EXPECT_EQ(place.planes, 2);
  }
}

TEST(TexturePath, KeepsToTheRulesOfRealTime) {
  for (const Case& c : cases()) {
    const Flat flat{Pose(), &c.texture};
    TexturePath path;
    testing::RealtimeTrap trap;
    Vec3d sum = Vec3d::Zero();
    for (int i = 0; i < 10'000; ++i) {
      trap.enter();
      sum += flat.tick(path, {i * 0.02, i * 0.013, -std::min(1.0, 0.01 * i)}).stretch;
      trap.leave();
      if (i < 100) trap.allocations = trap.locks = trap.systemCalls = trap.pageFaults = 0;
    }
    EXPECT_GT(sum.z(), 1000);
    EXPECT_EQ(trap.allocations + trap.locks + trap.systemCalls, 0u) << c.name;
  }
}

// The cost, for a person to read: nothing is expected of a machine that others use.
TEST(TexturePath, Cost) {
  for (const Case& c : cases()) {
    const Flat flat{Pose(), &c.texture};
    for (const double speed : {0.02, 0.2}) {
      TexturePath path;
      double sum = 0;
      constexpr int kTicks = 20'000;
      const auto begin = std::chrono::steady_clock::now();
      for (int i = 0; i < kTicks; ++i)
        sum += flat.tick(path, {i * speed, i * 0.3 * speed, -std::min(1.0, 0.01 * i)}).stretch.z();
      const double us =
          std::chrono::duration<double, std::micro>(std::chrono::steady_clock::now() - begin).count() / kTicks;
      std::printf("%s at %.0f mm/s: %.3f us a tick (%.0f)\n", c.name, speed * 1000, us, sum);
    }
  }
}

}  // namespace
}  // namespace argil::haptics
