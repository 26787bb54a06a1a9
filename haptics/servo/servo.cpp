#include "haptics/servo/servo.h"

#include <pthread.h>

#include <algorithm>

#include "clay/base/error.h"
#include "haptics/base/clock.h"

namespace argil::haptics {
namespace {

constexpr int64_t kWatchPeriodNs = 3'000'000;  // Watchdog: with kWatchdogSeconds, zero force within 20 ms.
constexpr int64_t kStartDelayNs = 2'000'000;
// A servo that cannot keep up sleeps so long after each tick all the same: others must run, and the kernel ends a
// real-time thread that never sleeps (RLIMIT_RTTIME).
constexpr int64_t kBreathNs = 100'000;

double checkedRate(double rateHz) {
  if (!(rateHz >= 100 && rateHz <= 8000)) throw Error("servo: the rate must be 100 to 8000 Hz");
  return rateHz;
}

}  // namespace

const char* sentence(ServoState state) noexcept {
  switch (state) {
    case ServoState::running:
      return "the device is felt";
    case ServoState::warm:
      return "the device's motors are warm: forces are weaker until they have cooled";
    case ServoState::waiting:
      return "forces wait: move the stylus away from what it touches";
    case ServoState::noScene:
      return "there is nothing to feel yet";
    case ServoState::silent:
      return "the device does not answer: check its plug and its power; forces come back gently once it does";
    case ServoState::hung:
      return "the machine is too busy for steady forces: the device was let go until it keeps up";
    case ServoState::stopped:
      return "forces are off after a fault: let the stylus rest, then reset the device";
  }
  return "unknown state";
}

ServoState Servo::state() const noexcept {
  if (fault() != Fault::none) return ServoState::stopped;
  if (hung_.load(std::memory_order_relaxed) && !device_.sheet().pointing) return ServoState::hung;
  const uint32_t flags = lastFlags_.load(std::memory_order_relaxed);
  if (flags & kStale) return ServoState::silent;
  if (flags & kNoScene) return ServoState::noScene;
  if (flags & kWaiting) return ServoState::waiting;
  return flags & kWarm ? ServoState::warm : ServoState::running;
}

Servo::Servo(Device& device, Published<Scene>& scene, const Options& options)
    : device_(device),
      options_(options),
      samples_(checkedRate(options.rateHz)),
      tick_(device, scene, samples_, 1.0 / options.rateHz, options.contact),
      statistics_(std::make_unique<ServoStatistics>()),
      copied_(std::make_unique<ServoStatistics>()) {}

Servo::~Servo() {
  stop();
}

void Servo::count(uint32_t flags) ARGIL_REALTIME {
  lastFlags_.store(flags, std::memory_order_relaxed);
  heat_.store(tick_.heat().load(), std::memory_order_relaxed);
  ServoStatistics& s = *statistics_;
  ++s.ticks;
  const auto add = [flags](TickFlag flag, uint64_t& counter) { counter += (flags & flag) != 0; };
  add(kTouching, s.touching);
  add(kLeaving, s.leaving);
  add(kCutting, s.cutting);
  add(kOverrun, s.overrun);
  add(kStale, s.stale);
  add(kClamped, s.clamped);
  add(kSlewed, s.slewed);
  add(kQueueFull, s.queueFull);
  add(kStopped, s.stopped);
  add(kWaiting, s.waiting);
  add(kIncomplete, s.incomplete);
  if (const uint64_t ticks = tick_.feltAfterTicks())
    s.editToFeel.add(static_cast<int64_t>(double(ticks) * 1e9 / options_.rateHz));
  s.peakForceN = std::max(s.peakForceN, tick_.last().forceN.norm());
}

void Servo::runVirtual(uint64_t ticks, const std::function<void(uint64_t, double)>& between) {
  if (running()) throw Error("servo: it runs in real time; stop it before running virtual time", Error::Kind::work);
  for (uint64_t i = 0; i < ticks; ++i) {
    const double timeS = double(nextIndex_) / options_.rateHz;
    if (between) between(nextIndex_, timeS);
    const int64_t begin = options_.measureCompute ? nowNs() : 0;
    count(tick_.run(timeS, false));
    if (options_.measureCompute) statistics_->compute.add(nowNs() - begin);
    ++nextIndex_;
  }
}

bool Servo::copyStatistics(ServoStatistics& out) {
  if (copy_.load(std::memory_order_acquire) == Copy::made || copy_.load() == Copy::none) {
    anyCopy_ = anyCopy_ || copy_.load() == Copy::made;
    if (anyCopy_) out = *copied_;
    copy_.store(Copy::wanted, std::memory_order_release);
    return anyCopy_;
  }
  return false;
}

RealtimeGrant Servo::start() {
  if (running()) throw Error("servo: it runs already", Error::Kind::work);
  stop_.store(false);
  ready_.store(false);
  heartbeat_.beat(double(nowNs()) * 1e-9 + 1.0);  // The watchdog is patient until the first tick.
  thread_ = std::thread([this] { loop(); });
  ready_.wait(false);
  watchdog_ = std::thread([this] { watch(); });
  return grant_;
}

void Servo::stop() {
  stop_.store(true);
  if (thread_.joinable()) thread_.join();
  if (watchdog_.joinable()) watchdog_.join();
}

void Servo::loop() {
  (void)pthread_setname_np(pthread_self(), "argil-servo");
  if (options_.realtime)
    grant_ = becomeRealtime(options_.priority, true);
  else
    grant_ = {false, false, "real-time scheduling not asked for"};
  const FlushDenormals flushed;
  const double periodNs = 1e9 / options_.rateHz;
  // Index nextIndex_ is due at `origin` + nextIndex_ · period, so that time goes on after a stop and never drifts.
  const int64_t first = nowNs() + kStartDelayNs;
  const auto origin = static_cast<int64_t>(double(first) - double(nextIndex_) * periodNs);
  if (parkedNs_) tick_.heat().felt(Vec3d::Zero(), double(nowNs() - parkedNs_) * 1e-9);
  int64_t breathed = 0;
  ready_.store(true);
  ready_.notify_one();

  while (!stop_.load(std::memory_order_relaxed)) {
    const auto due = origin + static_cast<int64_t>(double(nextIndex_) * periodNs);
    sleepUntilNs(std::max(due, breathed));
    const int64_t begin = nowNs();
    const int64_t late = begin - due;
    const bool overrun = double(late) > periodNs;
    if (overrun) {
      const auto skipped = static_cast<uint64_t>(double(late) / periodNs);
      statistics_->missed += skipped;
      nextIndex_ += skipped;
    }
    count(tick_.run(double(begin - origin) * 1e-9, overrun));
    statistics_->lateness.add(late);
    const int64_t end = nowNs();
    statistics_->compute.add(end - begin);
    heartbeat_.beat(double(end) * 1e-9);
    breathed = overrun ? end + kBreathNs : 0;
    ++nextIndex_;
    if (copy_.load(std::memory_order_acquire) == Copy::wanted) {
      *copied_ = *statistics_;
      copy_.store(Copy::made, std::memory_order_release);
    }
  }
  tick_.park(double(nextIndex_) / options_.rateHz);
  parkedNs_ = nowNs();
  if (grant_.locked) unlockMemory();
}

void Servo::watch() {
  (void)pthread_setname_np(pthread_self(), "argil-watchdog");
  // Above the servo: one that never returns from a tick must not starve its watchdog.
  if (options_.realtime) (void)becomeRealtime(std::min(options_.priority + 1, 99), false);
  Watchdog watchdog;
  int64_t next = nowNs();
  while (!stop_.load(std::memory_order_relaxed)) {
    next = std::max(next + kWatchPeriodNs, nowNs());
    sleepUntilNs(next);
    if (watchdog.look(heartbeat_, device_.gate(), double(nowNs()) * 1e-9)) cuts_.fetch_add(1);
    hung_.store(watchdog.holds(), std::memory_order_relaxed);
  }
  watchdog.end(device_.gate());
  hung_.store(false, std::memory_order_relaxed);
}

}  // namespace argil::haptics
