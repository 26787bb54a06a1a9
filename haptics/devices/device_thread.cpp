#include "haptics/devices/device_thread.h"

#include <pthread.h>

#include <algorithm>
#include <chrono>
#include <cstring>

#include "clay/base/error.h"
#include "haptics/base/clock.h"
#include "haptics/servo/safety.h"
#include "haptics/threads/realtime_thread.h"

namespace argil::haptics {
namespace {

// The servo and the device beat against each other; one hiccup of a bus is no fault.
constexpr double kLateExchanges = 4;

constexpr double kGuessExchanges = 2;  // Of delay, until it is measured: a soft beginning.

constexpr int64_t ns(double seconds) {
  return static_cast<int64_t>(seconds * 1e9);
}

bool sane(const DeviceState& s) {
  return s.pose.translation.allFinite() && s.pose.rotation.coeffs().allFinite() && s.pose.rotation.norm() > 0.5 &&
         s.pressure >= 0 && s.pressure <= 1;
}

}  // namespace

ThreadedDevice::ThreadedDevice(DeviceSheet sheet, std::unique_ptr<DeviceLink> link, const Options& options)
    : sheet_(std::move(sheet)),
      link_(std::move(link)),
      options_(options),
      delay_(sheet_.rateHz > 0 ? kGuessExchanges / sheet_.rateHz : 0) {
  if (!(sheet_.rateHz >= 1 && sheet_.rateHz <= 10000))
    throw Error("device " + sheet_.name + ": its sheet must name a rate of 1 to 10000 Hz");
  periodNs_ = ns(1 / sheet_.rateHz);
  lateNs_ = ns(options_.lateSeconds > 0 ? options_.lateSeconds : kLateExchanges / sheet_.rateHz);
  stallNs_ = std::max(ns(kStallSeconds), lateNs_);
  tell(DeviceCondition::opening, "opening");
  if (!options_.manual) thread_ = std::thread([this] { run(); });
}

ThreadedDevice::~ThreadedDevice() {
  stop_.store(true);
  stopping_.release();
  if (thread_.joinable()) thread_.join();
}

int64_t ThreadedDevice::servoNs(double timeS) const ARGIL_REALTIME {
  return options_.manual ? ns(timeS) : nowNs();
}

bool ThreadedDevice::read(double timeS, DeviceState& state) ARGIL_REALTIME {
  forces_.begin(gate());
  const bool fresh = answers_.load(answer_);
  const int64_t now = servoNs(timeS), age = now - answer_.atNs;
  if (!live_.load(std::memory_order_acquire) || age > lateNs_) return false;
  // A command of now waits as long as the last one did, and acts on a state as old as this one.
  if (fresh && answer_.lagNs >= 0) delay_.add(double(now - answer_.beganNs + answer_.lagNs) * 1e-9);
  state = answer_.state;
  state.ageS = double(std::max<int64_t>(0, age)) * 1e-9;
  return true;
}

void ThreadedDevice::write(double timeS, const Vec3d& forceN) ARGIL_REALTIME {
  Vec3d force = Vec3d::Zero();
  if (forceN.allFinite()) force = forceN;
  const double size = force.norm();
  if (size > sheet_.peakForceN) force *= sheet_.peakForceN / (size * (1 + 1e-15));
  forces_.put(force, servoNs(timeS));
}

std::string ThreadedDevice::status() const {
  const bool shut = !gate().open();
  Sentence sentence;
  {
    const std::scoped_lock lock(readers_);
    sentence_.load(sentence);
  }
  return sheet_.name + ": " + sentence.text + (shut ? "; its force is cut" : "");
}

void ThreadedDevice::tell(DeviceCondition condition, const std::string& text) {
  Sentence sentence;
  std::strncpy(sentence.text, text.c_str(), sizeof sentence.text - 1);
  sentence_.store(sentence);
  condition_.store(condition);
}

void ThreadedDevice::run() {
  (void)pthread_setname_np(pthread_self(), "argil-device");
  if (options_.realtime) (void)becomeRealtime(options_.priority, false);
  while (!stop_.load()) {
    std::string sentence;
    const DeviceLink::Opened opened = link_->open(sentence);
    if (opened == DeviceLink::Opened::ready) {
      serve(sentence);
      live_.store(false);
      link_->close();
    } else if (condition() != DeviceCondition::unplugged || opened == DeviceLink::Opened::refused) {
      tell(opened == DeviceLink::Opened::absent ? DeviceCondition::absent : DeviceCondition::faulted, sentence);
    }
    (void)stopping_.try_acquire_for(std::chrono::nanoseconds(ns(kRetrySeconds)));
  }
}

Vec3d ThreadedDevice::begin(int64_t nowNs) {
  beganNs_ = nowNs;
  if (forces_.take()) {
    lastWrittenNs_ = nowNs;
    lagNs_ = nowNs - forces_.putNs();
  }
  const bool heeded = answering_ && nowNs - lastWrittenNs_ <= ns(kWatchdogSeconds);
  return heeded ? forces_.allowed(gate()) : Vec3d::Zero();
}

void ThreadedDevice::end(DeviceLink::Exchanged result, const DeviceState& state, int64_t nowNs,
                         const std::string& where) {
  if (result == DeviceLink::Exchanged::state && !sane(state)) result = DeviceLink::Exchanged::garbage;
  if (result == DeviceLink::Exchanged::state) {
    answers_.store({state, nowNs, beganNs_, lagNs_});
    live_.store(true, std::memory_order_release);
    exchanges_.fetch_add(1, std::memory_order_relaxed);
    if (!answering_) tell(DeviceCondition::ready, "ready" + (where.empty() ? "" : " (" + where + ")"));
    answering_ = true;
    return;
  }
  live_.store(false);
  answering_ = false;
  if (result == DeviceLink::Exchanged::gone) {
    tell(DeviceCondition::unplugged, "unplugged; plug it in again and it goes on");
    return;
  }
  failures_.fetch_add(1, std::memory_order_relaxed);
  if (condition() != DeviceCondition::faulted)
    tell(DeviceCondition::faulted, result == DeviceLink::Exchanged::garbage
                                       ? "its answers make no sense; its force is zero until they do"
                                       : "it does not answer in time; its force is zero until it does");
}

void ThreadedDevice::serve(const std::string& where) {
  answering_ = false;
  lastWrittenNs_ = 0;
  lagNs_ = -1;
  int64_t lastGood = nowNs(), next = lastGood, last = lastGood;
  while (!stop_.load(std::memory_order_relaxed)) {
    const int64_t started = nowNs();
    if (started - last > stallNs_) gate().interrupt(StopOwner::device);
    DeviceState state;
    const DeviceLink::Exchanged result = link_->exchange(begin(started), started + lateNs_, state);
    const int64_t ended = last = nowNs();
    end(result, state, ended, where);
    if (answering_) {
      lastGood = ended;
    } else if (result == DeviceLink::Exchanged::gone) {
      return;
    } else if (ended - lastGood > ns(kSilentSeconds)) {
      tell(DeviceCondition::faulted,
           result == DeviceLink::Exchanged::nothing
               ? "silent; it is opened anew, look at its cable and its power if that does not help"
               : "its answers make no sense; it is opened anew, unplug it and plug it in if that does not help");
      return;
    }
    next = std::max(next + periodNs_, ended - periodNs_);  // One exchange may be made up for, a backlog not.
    if (next > ended) sleepUntilNs(next);
  }
}

}  // namespace argil::haptics
