// Stop is the last word in every order: users who stop, resume and change the device, the thread that carries it out,
// the servo, its watchdog and the device's thread, interleaved step by step in the real code.

#include <gtest/gtest.h>

#include <array>
#include <deque>
#include <functional>
#include <optional>

#include "../../support/interleaver.h"
#include "engine/session/force_control.h"
#include "haptics/devices/sheets.h"
#include "haptics/servo/force_line.h"
#include "haptics/servo/servo_tick.h"
#include "tests/support/tier.h"

namespace argil::engine {
namespace {

using argil::testing::Interleaver;
using haptics::ForceGate;
using haptics::StopOwner;

// The slew limit of a tick is then below the force that acts: a beginning is seen.
constexpr double kPeriodS = 1.0 / 8000;
constexpr double kForceN = 0.3;  // Below what a servo may begin with.

/// What the order of the steps has been so far. Each record is one step with what it records.
struct Ghost {
  uint64_t now = 0;
  uint64_t lastStop = 0;    // When a stop of a user had returned.
  uint64_t lastResume = 0;  // When a resume was called.
  uint64_t lastShut = 0;    // When anybody shut the gate.
  uint64_t handedOut = 0;   // Forces that were not zero.
};

/// A device as ThreadedDevice is one, but that the test turns its thread. Marks each command with its number.
class SteppedDevice final : public haptics::Device {
 public:
  explicit SteppedDevice(Ghost& ghost) : ghost_(ghost) {}
  const haptics::DeviceSheet& sheet() const noexcept override { return haptics::deviceSheet("touch"); }
  ForceGate& gate() const noexcept override {
    Interleaver::step();
    return Device::gate();
  }
  bool read(double, haptics::DeviceState&) ARGIL_REALTIME override {
    Interleaver::step();
    const ForceGate& shared = Device::gate();
    word_ = shared.word();
    began_.push_back(++ghost_.now);
    line_->begin(shared);
    Interleaver::step();
    return true;
  }
  void write(double, const Vec3d& force) ARGIL_REALTIME override {
    Interleaver::step();
    if (force.norm() > 0 && word_ != pushedAt_) {
      pushedAt_ = word_;
      steepest = std::max(steepest, force.norm());
    }
    line_->put(force.norm() > 0 ? Vec3d(double(began_.size() - 1), 0, force.z()) : Vec3d(Vec3d::Zero()));
    Interleaver::step();
  }
  void open(ForceGate& gate) {
    setGate(gate);
    line_.emplace();
    began_.clear();
    open_ = true;
  }
  void close() { open_ = false; }

  /// An exchange of the device's thread, up to the force that goes to the motor.
  void exchange() {
    Interleaver::step();
    if (!open_) return;
    (void)line_->take();
    Interleaver::step();
    if (!open_) return;
    const Vec3d force = line_->allowed(Device::gate());
    if (force == Vec3d::Zero()) return;
    ++ghost_.handedOut;
    if (ghost_.lastStop > ghost_.lastResume) ++lost;
    if (began_[size_t(force.x())] < ghost_.lastShut) ++old;
  }

  uint64_t lost = 0;    // Forces after a stop that no later resume undid.
  uint64_t old = 0;     // Forces of ticks that began before the gate was shut the last time.
  double steepest = 0;  // The largest force that a servo began with, N.

 private:
  Ghost& ghost_;
  std::optional<haptics::ForceLine> line_;
  std::vector<uint64_t> began_;
  ForceGate::Word word_ = 0, pushedAt_ = UINT64_MAX;
  bool open_ = false;
};

/// Stands for haptics::Servo: the same tick and watchdog, turned by the test.
class SteppedServo {
 public:
  SteppedServo(SteppedDevice& device, haptics::Published<haptics::Scene>& scene, double& nowS)
      : device_(device), ring_(10.0), tick_(device, scene, ring_, kPeriodS), nowS_(nowS) {}

  void start() {
    Interleaver::step();
    heart_.beat(nowS_ + 1.0);
    running_ = true;
    Interleaver::step();
  }
  void stop() {
    Interleaver::step();
    if (!running_) return;
    running_ = false;
    while (ticking_) Interleaver::step();
    tick_.park(nowS_);
    Interleaver::step();
    watchdog_.end(device_.gate());
  }
  void reset() {
    Interleaver::step();
    tick_.reset();
  }
  [[nodiscard]] uint32_t faults() const { return tick_.safety().faults(); }

  void turn() {
    Interleaver::step();
    if (!running_) return;
    ticking_ = true;
    nowS_ += kPeriodS;
    (void)tick_.run(nowS_, false);
    Interleaver::step();
    heart_.beat(nowS_);
    ticking_ = false;
  }
  /// True when it shut the gate.
  bool watch(ForceGate& gate) {
    Interleaver::step();
    return running_ && watchdog_.look(heart_, gate, nowS_);
  }
  [[nodiscard]] double slewStepN() const { return tick_.safety().slewStepN(); }

 private:
  SteppedDevice& device_;
  haptics::SampleRing ring_;
  haptics::ServoTick tick_;
  haptics::Heartbeat heart_;
  haptics::Watchdog watchdog_;
  double& nowS_;
  bool running_ = false, ticking_ = false;
};

/// The workbench's part: what callers do at once, and what waits for the edit thread.
class Bench {
 public:
  Bench() {
    haptics::Scene scene;
    scene.guides.push_back({1, haptics::Gravity{{0, 0, -kForceN}}, 0});
    scene.check();
    published.publish(std::make_unique<const haptics::Scene>(scene));
    for (Hand& hand : hands_) hand.servo.emplace(hand.device, published, nowS);
    current().device.open(gate);
    (void)beginUnlessStopped(gate, *current().servo);
  }

  void stop() {
    gate.stop(StopOwner::user);
    ghost.lastStop = ghost.lastShut = ++ghost.now;
    Interleaver::step();
    queue_.push_back([this] { restStopped(gate, *current().servo); });
  }
  void resume() {
    const SeenStops seen{gate.generation(StopOwner::user), current().servo->faults()};
    ghost.lastResume = ++ghost.now;
    Interleaver::step();
    queue_.push_back([this, seen] { (void)resumeSeen(gate, seen, *current().servo); });
  }
  void change() {
    queue_.push_back([this] {
      current().servo->stop();
      current().device.close();
      Interleaver::step();
      hand_ = 1 - hand_;
      current().servo->reset();
      current().device.open(gate);
      Interleaver::step();
      (void)beginUnlessStopped(gate, *current().servo);
    });
  }
  /// The edit thread: what waits first.
  bool carryOut() {
    Interleaver::step();
    if (queue_.empty()) return false;
    const std::function<void()> first = std::move(queue_.front());
    queue_.pop_front();
    first();
    return true;
  }
  void turn() { current().servo->turn(); }
  void watch() {
    if (current().servo->watch(gate)) ghost.lastShut = ++ghost.now;
  }
  void exchange() {
    for (Hand& hand : hands_) hand.device.exchange();
  }
  /// All that waits is done and the machine has time for so many ticks.
  void settle(int ticks) {
    while (carryOut()) {
    }
    for (int i = 0; i < ticks; ++i) {
      turn();
      watch();
      exchange();
    }
  }
  /// Whether the motor is given a force now.
  bool pushes() {
    const uint64_t before = ghost.handedOut;
    exchange();
    return ghost.handedOut > before;
  }
  uint64_t lost() const { return hands_[0].device.lost + hands_[1].device.lost; }
  uint64_t old() const { return hands_[0].device.old + hands_[1].device.old; }
  double steepest() const { return std::max(hands_[0].device.steepest, hands_[1].device.steepest); }
  double slewStepN() { return current().servo->slewStepN(); }

  Ghost ghost;
  ForceGate gate;
  double nowS = 0;
  haptics::Published<haptics::Scene> published;

 private:
  struct Hand {
    explicit Hand(Ghost& ghost) : device(ghost) {}
    SteppedDevice device;
    std::optional<SteppedServo> servo;
  };
  Hand& current() { return hands_[hand_]; }
  std::array<Hand, 2> hands_{Hand(ghost), Hand(ghost)};
  size_t hand_ = 0;
  std::deque<std::function<void()>> queue_;
};

TEST(Forces, AreZeroAfterAStopUntilALaterResumeInEveryOrder) {
#if defined(__SANITIZE_THREAD__)
  GTEST_SKIP() << "ThreadSanitizer knows of no fibers";
#endif
  const uint64_t schedules = tests::byTier(60'000, 3'000'000);
  Bench bench;
  uint64_t switches = 0, pushed = 0, resumed = 0, stopped = 0;
  for (uint64_t seed = 1; seed <= schedules; ++seed) {
    // A guide's force rises within 50 ms: now and then all of it is there when the order begins.
    bench.settle(seed % 100 ? 4 : 450);
    ASSERT_TRUE(bench.pushes()) << "seed " << seed;
    std::mt19937_64 random(seed);
    Interleaver order(seed, std::array{1.0, 0.5, 0.2}[random() % 3]);
    int users = 2;
    for (int user = 0; user < 2; ++user) {
      const uint64_t script = random();
      order.add([&, script] {
        for (int i = 0; i < 3; ++i) {
          Interleaver::step();
          switch ((script >> (8 * i)) % 5) {
            case 0:
            case 1:
              bench.stop();
              break;
            case 2:
            case 3:
              bench.resume();
              break;
            default:
              bench.change();
              break;
          }
        }
        --users;
      });
    }
    order.add([&] {
      while (bench.carryOut() || users > 0) {
      }
    });
    order.add([&] {
      for (int i = 0; i < 8; ++i) bench.turn();
    });
    order.add([&] {
      for (int i = 0; i < 10; ++i) bench.exchange();
    });
    const uint64_t stall = random();
    order.add([&] {
      // The servo is late when time goes on without it: the watchdog shuts the gate, and opens it once the servo lives.
      for (int i = 0; i < 4; ++i) {
        Interleaver::step();
        if ((stall >> i) & 1) bench.nowS += 0.016;
        bench.watch();
      }
    });
    order.run();
    switches += order.switches();
    bench.settle(4);
    ASSERT_EQ(bench.lost(), 0u) << "seed " << seed << ": a force after a stop that nobody undid";
    ASSERT_EQ(bench.old(), 0u) << "seed " << seed << ": a force from before a stop";
    // A servo that never pushed would keep the first promise too.
    const bool wanted = bench.ghost.lastResume >= bench.ghost.lastStop;
    ASSERT_EQ(bench.pushes(), wanted) << "seed " << seed;
    ++(wanted ? resumed : stopped);
    pushed = bench.ghost.handedOut;
    if (!wanted) bench.resume();
  }
  EXPECT_LE(bench.steepest(), bench.slewStepN() * (1 + 1e-9)) << "forces begin anew from zero";
  EXPECT_GT(bench.steepest(), 0.3 * kForceN) << "some began with all of it";
  EXPECT_LT(bench.slewStepN(), kForceN);
  EXPECT_GT(resumed, schedules / 10);
  EXPECT_GT(stopped, schedules / 10);
  std::printf("%llu schedules, %.1f switches each: %llu ended stopped, %llu pushing; %llu forces were handed out\n",
              static_cast<unsigned long long>(schedules), double(switches) / double(schedules),
              static_cast<unsigned long long>(stopped), static_cast<unsigned long long>(resumed),
              static_cast<unsigned long long>(pushed));
}

}  // namespace
}  // namespace argil::engine
