// Whatever a device says and a scene holds, in whatever order of time: no command over a limit, never one that is no
// number.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "haptics/contact/contact.h"
#include "haptics/devices/sheets.h"
#include "haptics/servo/servo_tick.h"
#include "tests/support/tier.h"

namespace argil::haptics {
namespace {

constexpr uint64_t kSeed = 20;
using Random = std::mt19937_64;

double unit(Random& random) {
  return 2 * double(random() >> 11) * 0x1p-53 - 1;
}
double odd(Random& random) {
  constexpr double kInf = std::numeric_limits<double>::infinity();
  constexpr double kOdd[] = {std::numeric_limits<double>::quiet_NaN(),
                             kInf,
                             -kInf,
                             1e300,
                             -1e300,
                             1e155,
                             1e9,
                             -1e7,
                             2e4,
                             2000,
                             5e-324,
                             -0.0,
                             0};
  return kOdd[random() % std::size(kOdd)];
}

/// A device gone mad, which checks what it is told.
class MadDevice final : public Device {
 public:
  MadDevice(DeviceSheet sheet, Random& random) : sheet_(std::move(sheet)), random_(random) {}
  [[nodiscard]] const DeviceSheet& sheet() const noexcept override { return sheet_; }

  bool read(double, DeviceState& state) ARGIL_REALTIME override {
    if (left_-- == 0) {
      // Mostly a hand: otherwise no run of ticks would be long enough to feel anything.
      mood_ = random_() % 3 ? random_() % 2 : random_() % 8;
      left_ = random_() % (mood_ < 3 ? 400 : 6);
      goal_ = 0.45 * sheet_.workspaceMm.cwiseProduct(Vec3d(unit(random_), unit(random_), unit(random_)));
      if (mood_ == 1) goal_ = Vec3d(8 * unit(random_), 8 * unit(random_), 2 + 4 * unit(random_));
    }
    answered = true;
    garbage = false;
    if (mood_ == 3) position_ = goal_;                        // A jump.
    if (mood_ != 2) position_ += 0.02 * (goal_ - position_);  // 2: stuck.
    state.pose.translation = position_;
    state.pressure = float(odd(random_));
    if (random_() % 50 == 0) buttons_ = uint32_t(random_());
    state.buttons = buttons_;
    switch (mood_) {
      case 4:
        state.pose.translation[long(random_() % 3)] = odd(random_);
        break;
      case 5:
        state.pose.rotation.coeffs()[long(random_() % 4)] = odd(random_);
        break;
      case 6:
        answered = false;
        break;
      case 7:
        state.pose.translation = Vec3d(odd(random_), odd(random_), odd(random_));
        break;
      default:
        break;
    }
    garbage = !state.pose.translation.allFinite() || !state.pose.rotation.coeffs().allFinite() ||
              state.pose.translation.norm() > kFarthestMm;
    return answered;
  }
  void write(double, const Vec3d& force) ARGIL_REALTIME override {
    before = told;
    told = force;
    ++writes;
  }

  bool answered = true, garbage = false;
  Vec3d told = Vec3d::Zero(), before = Vec3d::Zero();
  uint64_t writes = 0;

 private:
  DeviceSheet sheet_;
  Random& random_;
  uint64_t mood_ = 0, left_ = 0;
  uint32_t buttons_ = 0;
  Vec3d position_ = {0, 0, 12}, goal_ = Vec3d::Zero();
};

Scene anyScene(Random& random, std::span<const clay::Version> versions) {
  Scene scene;
  const auto spread = [&random](double decades) { return std::pow(10.0, decades * unit(random)); };
  for (size_t i = random() % 8 ? 1 + random() % 2 : 0; i > 0; --i) {
    Piece piece;
    piece.version = versions[random() % versions.size()];
    piece.pose.translation = 3 * Vec3d(unit(random), unit(random), unit(random));
    piece.pose.rotation = Eigen::AngleAxisd(unit(random), Vec3d::UnitX());
    scene.pieces.push_back(piece);
  }
  Material& m = scene.materials[0];
  m.stiffnessNmm = spread(4);
  m.hardnessNmm2 = spread(3);
  m.viscosityNsmm = spread(4);
  m.dragNsmm = spread(2) - 0.01;
  if (random() % 2) {
    m.staticFriction = 2 * std::abs(unit(random));
    m.dynamicFriction = m.staticFriction * std::abs(unit(random));
    m.viscousFrictionNsmm = 0.01 * std::abs(unit(random));
  }
  scene.tool.radiusMm = 3 * spread(0.7);
  if (random() % 2)
    scene.tool.work = std::array{haptics::Work::cut, haptics::Work::lay, haptics::Work::rub}[random() % 3];
  for (uint32_t id = 1; id <= 6; ++id) {
    const Vec3d point = 10 * Vec3d(unit(random), unit(random), unit(random));
    const Vec3d normal = Vec3d(unit(random), unit(random), 0.5).normalized();
    const WellShape well{5, 3};
    Guide guide;
    guide.id = id;
    guide.whileButtons = random() % 2 ? 16u << (random() % 3) : 0;
    switch (random() % 24) {
      case 0:
        guide.shape = LockToPoint{point};
        break;
      case 1:
        guide.shape = LockToLine{point, normal};
        break;
      case 2:
        guide.shape = LockToPlane{point, normal};
        break;
      case 3:
        guide.shape = LockToNormal{};
        break;
      case 4:
        guide.shape = KeepOutBox{Pose{point, Eigen::Quaterniond::Identity()}, Vec3d(3, 4, 5), random() % 2 == 0};
        break;
      case 5:
        guide.shape = KeepOutBall{point, 8, random() % 2 == 0};
        break;
      case 6:
        guide.shape = WellAtPoints{{point, -point}, well};
        break;
      case 7:
        guide.shape = WellAtPlane{point, normal, well};
        break;
      case 8:
        guide.shape = Gravity{2 * normal};
        break;
      case 9:
        guide.shape = Viscosity{0.01};
        break;
      case 10:
        guide.shape = AmbientPlane{point, normal, 0.5, 4};
        break;
      case 11:
        guide.shape = Buoyancy{point, normal, 2, 5};
        break;
      default:
        continue;
    }
    scene.guides.push_back(guide);
  }
  Workspace& w = scene.workspace;
  if (random() % 2) {
    w.scale = spread(random() % 4 ? 0.3 : 6);
    w.pose.rotation = Eigen::AngleAxisd(0.5 * unit(random), Vec3d::UnitY());
    w.pose.translation = 2 * Vec3d(unit(random), unit(random), unit(random));
    w.depthMm = 5 * unit(random);
    w.frame = random() % 4 ? Handedness::either : Handedness::left;
  }
  w.clutchButtons = random() % 3 ? 0 : 8;
  w.walls.on = random() % 3 == 0;
  w.walls.share = 0.1 + 0.45 * (1 + unit(random));
  w.walls.stiffnessNmm = spread(1);
  w.walls.speedMmsN = 500 * (1 + unit(random));
  scene.check();
  return scene;
}

void fuzz(const DeviceSheet& sheet, std::string_view contact, double periodS, uint64_t ticks, uint64_t seed) {
  SCOPED_TRACE(::testing::Message() << sheet.name << ", " << contact << ", period " << periodS << " s, seed " << seed);
  Random random(seed);
  const auto store = clay::Store::make();
  clay::Grid grid;
  grid.voxelMm = 1;
  const std::vector<clay::Version> versions = {clay::makeBlock(store, grid, {0, 0, -8}, {30, 30, 16}, 1),
                                               clay::makeBlock(store, grid, {0, 0, -2}, {30, 30, 16}, 1),
                                               clay::Version::empty(store, grid)};
  Published<Scene> scenes;
  MadDevice device(sheet, random);
  SampleRing ring(1 / periodS);
  ServoTick tick(device, scenes, ring, periodS, contact);
  std::array<StylusSample, 512> drained;
  double timeS = 0, latest = 0;  // Of the last tick whose time was a number.
  // Why the force is zero: forces have not begun, or they were interrupted for `awayS` and come back since `backS`.
  enum class Zero { notBegun, interrupted, no } zero = Zero::notBegun;
  double awayS = 0, backS = 0;
  bool lays = false;
  uint64_t stoppedFor = 0, returned = 0;
  uint64_t touching = 0, stopped = 0, waiting = 0, stale = 0, panning = 0, clutched = 0, slewed = 0, pushed = 0;
  for (uint64_t i = 0; i < ticks; ++i) {
    if (i >= 20 && random() % 300 == 0) {
      // Home again from wherever walls and clutch took it: the clay is there.
      if (random() % 2) tick.workspace().reset();
      auto scene = std::make_unique<const Scene>(anyScene(random, versions));
      lays = scene->tool.work == Work::lay;
      scenes.publish(std::move(scene));
    }
    // Time goes on, mostly.
    const double before = timeS;
    timeS = random() % 100 ? timeS + periodS : random() % 4 ? 10 * unit(random) : odd(random);
    // Now and then late by some periods, or bunched; a few stall for long.
    if (random() % 50 == 0) timeS = before + 6 * periodS * std::abs(unit(random));
    if (random() % 100 == 0) timeS = before + (random() % 4 ? 0.4 : 1.5) * kAwaySeconds * std::abs(unit(random));
    if (random() % 10'000 == 0) {
      tick.park(0);
      zero = Zero::notBegun;
    }
    const uint32_t flags = tick.run(timeS, random() % 50 == 0);
    const Vec3d force = device.told;
    ASSERT_TRUE(force.allFinite()) << "tick " << i;
    ASSERT_LE(force.norm(), sheet.peakForceN) << "tick " << i;
    ASSERT_TRUE(tick.last().forceN.allFinite()) << "tick " << i;
    ASSERT_TRUE(tick.last().device.translation.allFinite()) << "tick " << i;
    const double elapsed = timeS > latest ? timeS - latest : 0;
    // After a gap forces come from zero.
    const bool gap = elapsed > periodS + kStallSeconds;
    if (!device.answered || gap) {
      awayS += elapsed;
      backS = 0;
      if (zero == Zero::no) zero = Zero::interrupted;
      if (awayS > kAwaySeconds) zero = Zero::notBegun;
    }
    if (device.garbage) zero = Zero::notBegun;
    if (!device.answered || device.garbage) {
      ASSERT_EQ(force, Vec3d::Zero()) << "tick " << i;
    } else {
      // A fault fades as fast as its time asks for.
      const double shrunk = (flags & kStopped) != 0 ? device.before.norm() - force.norm() : 0;
      ASSERT_GE(shrunk, 0) << "tick " << i;
      ASSERT_LE((force - (gap ? Vec3d(Vec3d::Zero()) : device.before)).norm(),
                std::max(shrunk, tick.safety().slewStepN()) * (1 + 1e-9))
          << "tick " << i;
      // After a stop or a long silence nothing is felt until what would be felt is small; after a short one it grows.
      if (flags & kStopped) zero = Zero::notBegun;
      if (!(flags & (kStopped | kWaiting))) {
        awayS = 0;
        if (zero == Zero::notBegun) {
          ASSERT_LE(force.norm(), kStartFraction * sheet.peakForceN) << "tick " << i;
          zero = Zero::no;
        } else if (zero == Zero::interrupted) {
          backS += std::min(elapsed, periodS) + 1e-9;  // What counts as one period is as near to it.
          ASSERT_LE(force.norm(), backS / kReturnSeconds * sheet.peakForceN * (1 + 1e-9)) << "tick " << i;
          ASSERT_TRUE(!(flags & kCutting) || lays || backS >= kReturnSeconds) << "tick " << i;
          ++returned;
          if (backS >= kReturnSeconds) zero = Zero::no;
        }
      }
      ASSERT_FALSE((flags & kWaiting) && (flags & kCutting) && !lays) << "tick " << i;
    }
    if (std::isfinite(timeS)) latest = timeS;
    ASSERT_LE(tick.heat().load(), 1 + 1e-3) << "tick " << i;
    touching += (flags & kTouching) != 0;
    stopped += (flags & kStopped) != 0;
    waiting += (flags & kWaiting) != 0;
    stale += (flags & kStale) != 0;
    panning += (flags & kPanning) != 0;
    clutched += (flags & kClutched) != 0;
    slewed += (flags & kSlewed) != 0;
    pushed += force.norm() > 0;
    stoppedFor = flags & kStopped ? stoppedFor + 1 : 0;
    if (double(stoppedFor) * periodS > 1.5 * kFadeSeconds) {
      ASSERT_EQ(force, Vec3d::Zero());
      tick.reset();
      zero = Zero::notBegun;
    }
    if (i % 500 == 0) (void)ring.pop(drained);
  }
  const auto percent = [ticks](uint64_t n) { return 100 * double(n) / double(ticks); };
  std::printf(
      "%-9s %-10s %.0f Hz %llu ticks: touching %.0f %%, pushed %.0f %%, stopped %.0f %%, waiting %.0f %%, silent %.1f "
      "%%, panning %.0f %%, clutched %.0f %%, slewed %.1f %%\n",
      sheet.name.c_str(), std::string(contact).c_str(), 1 / periodS, static_cast<unsigned long long>(ticks),
      percent(touching), percent(pushed), percent(stopped), percent(waiting), percent(stale), percent(panning),
      percent(clutched), percent(slewed));
  if (tick.safety().slewStepN() > sheet.peakForceN) slewed = ticks;  // At a slow rate no step is too steep.
  for (uint64_t seen : {touching, stopped, waiting, stale, panning, clutched, slewed, pushed, returned})
    EXPECT_GT(seen, ticks / 5000) << "something was never tried";
}

// 10^7 ticks in the long tier.
TEST(ServoFuzz, NoCommandIsEverOverALimit) {
  const uint64_t ticks = tests::byTier(200'000, 10'000'000);
  const std::span<const DeviceSheet> sheets = deviceSheets();
  // Half of them for the contact that is used, at the usual rate; the rest for the others and for slow and fast servos.
  for (size_t i = 0; i < sheets.size(); ++i) fuzz(sheets[i], "proxy", 1e-3, ticks / 2 / sheets.size(), kSeed + i);
  for (double periodS : {1.0 / 100, 1.0 / 8000}) fuzz(sheets[0], "proxy", periodS, ticks / 8, kSeed);
  const auto names = contactNames();
  for (size_t i = 0; i < names.size(); ++i) fuzz(sheets[1], names[i], 1e-3, ticks / 4 / names.size(), kSeed + i);
}

}  // namespace
}  // namespace argil::haptics
