#include "haptics/devices/device_thread.h"

#include <algorithm>
#include <chrono>
#include <cstring>

#include "clay/error.h"
#include "haptics/clock.h"
#include "haptics/realtime_thread.h"
#include "haptics/safety.h"

namespace argil::haptics {
namespace {

constexpr double kLateExchanges = 4;  // The servo and the device beat against each other; one hiccup of a bus is no fault.

constexpr int64_t ns(double seconds) { return static_cast<int64_t>(seconds * 1e9); }

bool sane(const DeviceState& s) {
  return s.pose.translation.allFinite() && s.pose.rotation.coeffs().allFinite() && s.pose.rotation.norm() > 0.5 && s.pressure >= 0 &&
         s.pressure <= 1;
}

}  // namespace

ThreadedDevice::ThreadedDevice(DeviceSheet sheet, std::unique_ptr<DeviceLink> link, const Options& options)
    : sheet_(std::move(sheet)), link_(std::move(link)), options_(options) {
  if (!(sheet_.rateHz >= 1 && sheet_.rateHz <= 10000)) throw Error("device " + sheet_.name + ": its sheet must name a rate of 1 to 10000 Hz");
  periodNs_ = ns(1 / sheet_.rateHz);
  lateNs_ = ns(options_.lateSeconds > 0 ? options_.lateSeconds : kLateExchanges / sheet_.rateHz);
  stallNs_ = std::max(ns(kStallSeconds), lateNs_);
  tell(DeviceCondition::opening, "opening");
  thread_ = std::thread([this] { run(); });
}

ThreadedDevice::~ThreadedDevice() {
  stop_.store(true);
  stopping_.release();
  thread_.join();
}

bool ThreadedDevice::read(double, DeviceState& state) ARGIL_REALTIME {
  forces_.begin(gate());
  answers_.load(answer_);
  const int64_t age = nowNs() - answer_.atNs;
  if (!live_.load(std::memory_order_acquire) || age > lateNs_) return false;
  state = answer_.state;
  state.ageS = double(std::max<int64_t>(0, age)) * 1e-9;
  return true;
}

void ThreadedDevice::write(double, const Vec3d& forceN) ARGIL_REALTIME {
  Vec3d force = Vec3d::Zero();
  if (forceN.allFinite()) force = forceN;
  const double size = force.norm();
  if (size > sheet_.peakForceN) force *= sheet_.peakForceN / (size * (1 + 1e-15));
  forces_.put(force);
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

void ThreadedDevice::serve(const std::string& where) {
  bool answering = false;
  int64_t lastGood = nowNs(), lastWritten = 0, next = lastGood, last = lastGood;
  while (!stop_.load(std::memory_order_relaxed)) {
    const int64_t begin = nowNs();
    if (begin - last > stallNs_) gate().interrupt(StopOwner::device);
    if (forces_.take()) lastWritten = begin;
    const bool heeded = answering && begin - lastWritten <= ns(kWatchdogSeconds);
    DeviceState state;
    DeviceLink::Exchanged result =
        link_->exchange(heeded ? forces_.allowed(gate()) : Vec3d::Zero(), begin + lateNs_, state);
    const int64_t end = last = nowNs();
    if (result == DeviceLink::Exchanged::state && !sane(state)) result = DeviceLink::Exchanged::garbage;
    if (result == DeviceLink::Exchanged::state) {
      answers_.store({state, end});
      live_.store(true, std::memory_order_release);
      exchanges_.fetch_add(1, std::memory_order_relaxed);
      lastGood = end;
      if (!answering) tell(DeviceCondition::ready, "ready" + (where.empty() ? "" : " (" + where + ")"));
      answering = true;
    } else {
      live_.store(false);
      if (result == DeviceLink::Exchanged::gone) {
        tell(DeviceCondition::unplugged, "unplugged; plug it in again and it goes on");
        return;
      }
      failures_.fetch_add(1, std::memory_order_relaxed);
      const bool garbage = result == DeviceLink::Exchanged::garbage;
      if (condition() != DeviceCondition::faulted)
        tell(DeviceCondition::faulted, garbage ? "its answers make no sense; its force is zero until they do" : "it does not answer in time; its force is zero until it does");
      answering = false;
      if (end - lastGood > ns(kSilentSeconds)) {
        tell(DeviceCondition::faulted, garbage ? "its answers make no sense; it is opened anew, unplug it and plug it in if that does not help"
                                               : "silent; it is opened anew, look at its cable and its power if that does not help");
        return;
      }
    }
    next = std::max(next + periodNs_, end - periodNs_);  // One exchange may be made up for, a backlog not.
    if (next > end) sleepUntilNs(next);
  }
}

}  // namespace argil::haptics
