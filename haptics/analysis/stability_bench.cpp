#include "haptics/analysis/stability_bench.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <memory>
#include <vector>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "haptics/devices/device_thread.h"
#include "haptics/servo/servo_tick.h"

namespace argil::haptics {
namespace {

// Small voxels: contact's own tolerance (0.02 of one) is below what is judged.
constexpr double kToolMm = 1, kVoxelMm = 0.25;
constexpr double kGrowMm = 1;
constexpr double kPress = 0.25;  // Of the peak: how hard the hand presses.
constexpr double kGlideMms = 20;
constexpr double kRestMm = 2;  // Above the clay, before and between.
constexpr double kWindowS = 0.1;
constexpr double kSide = 16, kDeep = 4;                    // Of the clay, mm.
constexpr double kLeast = 0.5, kMost = 200, kRung = 1.25;  // N/mm; of the ladder.

struct Blocks {
  clay::Version flat, grown;
  Blocks() {
    clay::Grid grid;
    grid.voxelMm = kVoxelMm;
    const auto store = clay::Store::make();
    flat = clay::makeBlock(store, grid, {0, 0, -kDeep / 2}, {2 * kSide, kSide, kDeep}, 0.5);
    grown = clay::makeBlock(store, grid, {0, 0, (kGrowMm - kDeep) / 2}, {2 * kSide, kSide, kDeep + kGrowMm}, 0.5);
  }
};

std::unique_ptr<const Scene> sceneOf(const clay::Version& version, double voxelOffset = 0) {
  auto scene = std::make_unique<Scene>();
  scene->pieces.push_back({version, Pose(), 0});
  // Not on a corner of the voxels, and as stiff as the coupling wants it.
  scene->pieces[0].pose.translation = {0.07, 0.11, voxelOffset};
  scene->materials[0].stiffnessNmm = 1e4;
  scene->tool.radiusMm = kToolMm;
  scene->check();
  return scene;
}

const Blocks& blocks() {
  static const Blocks all;
  return all;
}

// A hand that only pushes holds no place.
bool none(const HandModel& hand) {
  return !(hand.stiffnessNmm > 0);
}

struct Plan {
  HandPath path;
  double endS = 0, judgedFromS = 0, growS = -1;
};

HandPoint at(double timeS, double x, double z, double fx, double fz) {
  HandPoint p;
  p.timeS = timeS;
  p.position = {x, 0, z};
  p.forceN = {fx, 0, fz};
  return p;
}

// How hard to press: what would hold the tool midway between two encoder steps, the worst place (Diolaiti).
double pressOf(const StabilityCase& c) {
  const double wanted = kPress * c.sheet.peakForceN, step = c.sheet.resolutionMm;
  if (!(step > 0)) return wanted;
  const double stretch = kToolMm - (std::floor((kToolMm - wanted / c.coupling.stiffnessNmm) / step) + 0.5) * step;
  return c.coupling.stiffnessNmm * (stretch > 0 ? stretch : stretch + step);
}

// Where the hand goes: `deep` is where its spring pulls with the force that it presses with.
Plan planOf(const StabilityCase& c) {
  const double press = pressOf(c), touch = kToolMm, free = touch + kRestMm;
  const bool pushes = none(c.hand);
  const double deep = pushes ? 0 : touch - press / c.hand.stiffnessNmm - press / c.coupling.stiffnessNmm;
  Plan plan;
  std::vector<HandPoint> p;
  const auto go = [&](double timeS, double x, double z, double force, double along = 0) {
    p.push_back(at(timeS, x, pushes ? free : z, pushes ? along : 0, pushes ? force : 0));
  };
  // Enough to overcome friction and go at the gliding speed.
  const double drag = c.sheet.frictionN + c.sheet.dampingNsmm * kGlideMms;
  const double lift = c.sheet.frictionN + 0.3 * press;
  go(0, 0, free, 0);
  go(0.05, 0, free, 0);
  switch (c.task) {
    case StabilityTask::grasp:
    case StabilityTask::grow:
      go(0.35, 0, deep, -press);
      plan.growS = c.task == StabilityTask::grow ? 0.6 : -1;
      plan.endS = c.task == StabilityTask::grow ? 1.8 : 1.4;
      break;
    case StabilityTask::tap: {
      double t = 0.05;
      for (int hit = 0; hit < 3; ++hit) {
        go(t + 0.03, 0, deep, -press);  // As fast as a hand strikes.
        go(t + 0.10, 0, deep, -press);
        if (hit == 2) break;
        go(t + 0.15, 0, free, lift);
        go(t + 0.20, 0, free, 0);
        t += 0.20;
      }
      plan.endS = t + 1.2;
      break;
    }
    case StabilityTask::glide: {
      go(0.35, 0, deep, -press);
      go(0.5, 0, deep, -press);
      go(0.52, 0, deep, -press, drag);
      go(1.5, kGlideMms * 0.98, deep, -press, drag);
      plan.endS = 1.4;
      break;
    }
  }
  for (HandPoint& q : p) q.position.x() -= 0.6 * kSide;
  plan.path = HandPath(std::move(p));
  plan.judgedFromS = plan.endS - kJudgedS;
  return plan;
}

// Largest peak-to-peak of a value in any window.
class Swing {
 public:
  explicit Swing(size_t window) : window_(window) {}
  void see(double z) { all_.push_back(z); }
  [[nodiscard]] double first() const { return between(0); }
  [[nodiscard]] double last() const { return between(all_.size() - std::min(all_.size(), window_)); }
  [[nodiscard]] double largest() const {
    double worst = 0;
    for (size_t from = 0; from + window_ <= all_.size(); from += std::max<size_t>(1, window_ / 2)) {
      const auto [lo, hi] = std::minmax_element(all_.begin() + static_cast<ptrdiff_t>(from),
                                                all_.begin() + static_cast<ptrdiff_t>(from + window_));
      worst = std::max(worst, *hi - *lo);
    }
    return worst;
  }

 private:
  [[nodiscard]] double between(size_t from) const {
    const auto begin = all_.begin() + static_cast<ptrdiff_t>(from);
    const auto [lo, hi] =
        std::minmax_element(begin, begin + static_cast<ptrdiff_t>(std::min(window_, all_.size() - from)));
    return all_.empty() ? 0 : *hi - *lo;
  }

  size_t window_;
  std::vector<double> all_;
};

/// A simulated device behind a ThreadedDevice: its exchanges have a time of their own, in virtual time.
class ThreadedHand final : public Device {
 public:
  ThreadedHand(SimulatedDevice& device, double exchangesHz, double exchangeS)
      : device_(device),
        threaded_(sheetOf(device, exchangesHz), nullptr, optionsOf()),
        periodNs_(1.0013e9 / exchangesHz),
        exchangeNs_(1e9 * exchangeS) {}

  const DeviceSheet& sheet() const noexcept override { return threaded_.sheet(); }
  bool read(double timeS, DeviceState& state) ARGIL_REALTIME override {
    turn(1e9 * timeS);
    return threaded_.read(timeS, state);
  }
  void write(double timeS, const Vec3d& forceN) ARGIL_REALTIME override { threaded_.write(timeS, forceN); }
  ForceGate& gate() const noexcept override { return threaded_.gate(); }
  double delayS() const ARGIL_REALTIME override { return threaded_.delayS(); }

 private:
  static DeviceSheet sheetOf(const SimulatedDevice& device, double exchangesHz) {
    DeviceSheet sheet = device.sheet();
    sheet.rateHz = exchangesHz;
    return sheet;
  }
  static ThreadedDevice::Options optionsOf() {
    ThreadedDevice::Options options;
    options.manual = true;
    options.lateSeconds = 0.1;  // Of exchanges that take their time nothing is late.
    return options;
  }
  // All that the device's thread does until then.
  void turn(double untilNs) {
    for (;;) {
      const double next = stage_ == 0 ? beginNs_ : stage_ == 1 ? beginNs_ + 0.5 * exchangeNs_ : beginNs_ + exchangeNs_;
      if (next > untilNs) return;
      const auto at = static_cast<int64_t>(next);
      if (stage_ == 0) {
        force_ = threaded_.begin(at);
      } else if (stage_ == 1) {
        (void)device_.read(next * 1e-9, state_);
        device_.write(next * 1e-9, force_);
      } else {
        threaded_.end(DeviceLink::Exchanged::state, state_, at);
        beginNs_ += std::max(periodNs_, exchangeNs_);
      }
      stage_ = (stage_ + 1) % 3;
    }
  }

  SimulatedDevice& device_;
  ThreadedDevice threaded_;
  double periodNs_, exchangeNs_, beginNs_ = 0.37e6;
  int stage_ = 0;
  Vec3d force_ = Vec3d::Zero();
  DeviceState state_;
};

/// The closed loop: one tick after another, and what energy goes where.
class Loop {
 public:
  Loop(const StabilityCase& c, const HandPath& path)
      : device_(c.sheet, path, optionsOf(c)),
        threaded_(c.exchangesHz > 0 ? std::make_unique<ThreadedHand>(device_, c.exchangesHz, c.delayS) : nullptr),
        sheet_(c.sheet),
        ring_(4),
        tick_(start(threaded_ ? static_cast<Device&>(*threaded_) : device_, published_), published_, ring_,
              1 / c.rateHz),
        rate_(c.rateHz) {
    if (!threaded_) tick_.couple(c.coupling, c.controlled, c.delayS);
  }
  [[nodiscard]] double delayS() const { return threaded_ ? threaded_->delayS() : 0; }
  Published<Scene>& published() { return published_; }
  void turn() {
    const Vec3d before = device_.position();
    const double timeS = static_cast<double>(index_++) / rate_;
    StylusSample dropped;
    flags = tick_.run(timeS, false);
    (void)ring_.pop(std::span(&dropped, 1));
    // The tick moved the device first, under the commands before.
    const Vec3d moved = device_.position() - before;
    work += motor_.dot(moved);
    lost += sheet_.dampingNsmm * moved.squaredNorm() * rate_ + sheet_.frictionN * moved.norm();
    motor_ = tick_.last().forceN;
  }
  [[nodiscard]] const SimulatedDevice& device() const { return device_; }
  [[nodiscard]] const ServoTick& tick() const { return tick_; }
  [[nodiscard]] Vec3d force() const { return motor_; }
  uint32_t flags = 0;
  double work = 0, lost = 0;  // N·mm: of the motor on the tool; by the mechanism. Exact without a delay.

 private:
  static SimulatedDevice::Options optionsOf(const StabilityCase& c) {
    SimulatedDevice::Options o;
    o.hand = c.hand;
    o.delayS = c.exchangesHz > 0 ? 0 : c.delayS;
    o.encoderSteps = c.encoderSteps;
    o.fineStepS = c.rateHz > 2000 ? 2.5e-5 : 5e-5;
    return o;
  }
  static Device& start(Device& device, Published<Scene>& published) {
    published.publish(sceneOf(blocks().flat));
    return device;
  }

  Published<Scene> published_;
  SimulatedDevice device_;
  std::unique_ptr<ThreadedHand> threaded_;
  DeviceSheet sheet_;
  SampleRing ring_;
  ServoTick tick_;
  double rate_;
  uint64_t index_ = 0;
  Vec3d motor_ = Vec3d::Zero();
};

}  // namespace

std::span<const StabilityHand> stabilityHands() {
  // Of the size that studies of fingers and arms on a stylus report; the mass is what moves with the tool.
  static const StabilityHand hands[] = {
      {"none", {0, 0, 0}}, {"light", {0.03, 0.002, 0.15}}, {"firm", {0.15, 0.012, 0.8}}};
  return hands;
}

const char* name(StabilityTask task) noexcept {
  switch (task) {
    case StabilityTask::grasp:
      return "grasp";
    case StabilityTask::tap:
      return "tap";
    case StabilityTask::glide:
      return "glide";
    case StabilityTask::grow:
      return "grow";
  }
  return "?";
}

StabilityFigures runStability(const StabilityCase& asked) {
  StabilityCase what = asked;
  if (!what.encoderSteps) what.sheet.resolutionMm = 0;
  if (what.exchangesHz > 0)
    // About: for the plan.
    what.coupling = coupleTo(what.sheet, std::max(1 / what.rateHz, 1 / what.exchangesHz), what.delayS);
  const Plan plan = planOf(what);
  Loop loop(what, plan.path);
  const auto ticks = static_cast<uint64_t>(plan.endS * what.rateHz);
  const auto judgedFrom = static_cast<uint64_t>(plan.judgedFromS * what.rateHz);
  const auto grow =
      plan.growS > 0 ? static_cast<uint64_t>(plan.growS * what.rateHz) : std::numeric_limits<uint64_t>::max();
  StabilityFigures f;
  Swing swing(static_cast<size_t>(kWindowS * what.rateHz));
  Vec3d last = Vec3d::Zero();
  for (uint64_t i = 0; i < ticks; ++i) {
    if (i == grow) loop.published().publish(sceneOf(blocks().grown));
    loop.turn();
    const Vec3d force = loop.force();
    f.peakN = std::max(f.peakN, force.norm());
    f.stopped = f.stopped || (loop.flags & kStopped);
    if (i >= judgedFrom) {
      f.jumpN = std::max(f.jumpN, (force - last).norm());
      swing.see(loop.device().position().z());
    }
    last = force;
  }
  f.cycleMm = swing.largest();
  f.startCycleMm = swing.first();
  f.endCycleMm = swing.last();
  f.delayS = what.exchangesHz > 0 ? loop.delayS() : what.delayS;
  f.stiffnessNmm = loop.tick().coupling().stiffnessNmm;
  f.givenNmm = loop.work - loop.lost;
  double allowed = kQuietJump * what.sheet.peakForceN;
  if (what.task == StabilityTask::glide && what.encoderSteps)
    allowed += what.coupling.stiffnessNmm * what.sheet.resolutionMm;
  f.quiet = !f.stopped && f.cycleMm <= kQuietCycleMm && f.jumpN <= allowed;
  return f;
}

double largestQuietStiffness(StabilityCase what) {
  const auto quiet = [&](double stiffness) {
    what.coupling.stiffnessNmm = stiffness;
    return runStability(what).quiet;
  };
  double good = 0, bad = 0;
  for (double k = kLeast; k <= kMost; k *= kRung) {
    if (!quiet(k)) {
      bad = k;
      break;
    }
    good = k;
  }
  if (good == 0 || bad == 0) return good;
  while (bad > 1.04 * good) {
    const double middle = std::sqrt(good * bad);
    (quiet(middle) ? good : bad) = middle;
  }
  return good;
}

ContactEnergy energyOfContacts(const StabilityCase& what, uint64_t contacts) {
  constexpr double kBeatS = 0.08;  // Down, and up again.
  constexpr uint64_t kLap = 100;   // Taps until the path begins anew.
  const double press = kPress * what.sheet.peakForceN, free = kToolMm + 0.5;
  const double deep = kToolMm - press / what.hand.stiffnessNmm - press / what.coupling.stiffnessNmm;
  ContactEnergy energy;
  while (energy.contacts < contacts) {
    std::vector<HandPoint> p{at(0, 0, free, 0, 0)};
    for (uint64_t i = 0; i < kLap; ++i) {
      // Each a little different, so that encoder steps fall everywhere.
      const double shift = 0.01 * static_cast<double>((i + energy.contacts / kLap) % 13);
      const double t = kBeatS * static_cast<double>(i) + 0.05;
      p.push_back(at(t + 0.5 * kBeatS, 0, deep - shift, 0, 0));
      p.push_back(at(t + kBeatS, 0, free + shift, 0, 0));
    }
    Loop loop(what, HandPath(std::move(p)));
    const double end = kBeatS * static_cast<double>(kLap) + 0.3;
    bool touching = false;
    double workAtStart = 0, lostAtStart = 0;
    for (uint64_t i = 0; i < static_cast<uint64_t>(end * what.rateHz) && energy.contacts < contacts; ++i) {
      const double work = loop.work, lost = loop.lost;
      loop.turn();
      const bool now = (loop.flags & kTouching) != 0 || loop.force().norm() > 0;
      if (now && !touching) workAtStart = work, lostAtStart = lost;
      if (!now && touching) {
        ++energy.contacts;
        const double done = loop.work - workAtStart, given = done - (loop.lost - lostAtStart);
        energy.workNmm += done;
        energy.givenNmm += std::max(0.0, given);
        energy.worstNmm = std::max(energy.worstNmm, done);
      }
      touching = now;
    }
  }
  return energy;
}

}  // namespace argil::haptics
