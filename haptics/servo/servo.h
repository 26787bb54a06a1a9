#pragma once
// The servo loop: 1 to 8 kHz on absolute time, or as many ticks as wanted in virtual time.

#include <atomic>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "haptics/base/histogram.h"
#include "haptics/servo/servo_tick.h"
#include "haptics/threads/realtime_thread.h"

namespace argil::haptics {

/// What was counted over all ticks since the servo was made.
struct ServoStatistics {
  Histogram compute;   ///< Duration of a tick.
  Histogram lateness;  ///< Of its beginning after its time; paced only.
  /// From a sample to the tick that feels the clay as it changed it, the oldest of each edit; whole ticks.
  Histogram editToFeel;
  uint64_t ticks = 0, touching = 0, leaving = 0, cutting = 0;
  uint64_t overrun = 0, stale = 0, clamped = 0, slewed = 0, queueFull = 0, stopped = 0, incomplete = 0;
  uint64_t missed = 0;   ///< Ticks that never were because one before them was late.
  uint64_t waiting = 0;  ///< Forces waited to begin, and tools rested.
  double peakForceN = 0;
};

/// What a person is told about a servo.
enum class ServoState : uint8_t {
  running,
  warm,     ///< Runs; forces are held below the peak until the motors have cooled.
  waiting,  ///< Forces begin once they are small; until then tools rest but those that lay clay.
  noScene,  ///< Nothing published yet.
  silent,   ///< The device does not answer; zero force until it does.
  hung,     ///< The watchdog has cut the device: no tick ended for kWatchdogSeconds.
  stopped,  ///< Latched at zero by a fault, until reset().
};
/// What it is and what to do about it. A fault's own sentence says more.
[[nodiscard]] const char* sentence(ServoState state) noexcept;

/// A device, its tick and the thread that turns it. Made and used by one thread.
class Servo {
 public:
  struct Options {
    double rateHz = 1000;  ///< 100 to 8000.
    bool realtime = true;  ///< Ask for real-time scheduling and locked memory in start().
    int priority = 80;
    std::string contact = "proxy";  ///< One of contactNames().
    bool measureCompute = true;     ///< Also in virtual time.
  };

  /// `device` and `scene` must outlive it. Throws Error for options out of range.
  Servo(Device& device, Published<Scene>& scene, const Options& options);
  Servo(Device& device, Published<Scene>& scene) : Servo(device, scene, Options()) {}
  ~Servo();
  Servo(const Servo&) = delete;
  Servo& operator=(const Servo&) = delete;

  /// Runs `ticks` ticks of virtual time at once, in the calling thread, on from where the last call ended. `between` is
  /// called before each tick, outside of it, with the index and the time of the tick to come: the session drains
  /// samples and publishes there, so that a publishing delay counted in ticks is the same in every run.
  void runVirtual(uint64_t ticks, const std::function<void(uint64_t index, double timeS)>& between = {});

  /// Starts the paced thread and a watchdog beside it; returns what the system granted, within kRealtimeKitSeconds.
  /// Throws Error when it already runs.
  RealtimeGrant start();
  /// Stops both; the device is at zero force and the scene is let go. Idempotent.
  void stop();
  /// What the system granted at the last start; empty before. The thread that starts and stops.
  [[nodiscard]] const std::string& grant() const noexcept { return grant_.sentence; }
  [[nodiscard]] bool running() const noexcept { return thread_.joinable(); }

  [[nodiscard]] SampleRing& samples() noexcept { return samples_; }                         ///< One consumer.
  [[nodiscard]] LatestValue<StylusSample>& latest() noexcept { return tick_.latest(); }     ///< One reader.
  [[nodiscard]] LatestValue<Reactions>& reactions() noexcept { return tick_.reactions(); }  ///< One reader.
  /// Asks the running servo for a copy of its statistics and gives the last one that came: false before the first. The
  /// copy is made between two ticks, some µs. One thread.
  bool copyStatistics(ServoStatistics& out);
  /// Only while the servo does not run.
  [[nodiscard]] const ServoStatistics& statistics() const noexcept { return *statistics_; }
  [[nodiscard]] ServoTick& tick() noexcept { return tick_; }
  /// Why the force is latched at zero, if it is. Any thread.
  [[nodiscard]] Fault fault() const noexcept { return tick_.safety().fault(); }
  /// What the last tick ended with. Any thread.
  [[nodiscard]] ServoState state() const noexcept;
  /// HeatBudget::load() after the last tick. Any thread.
  [[nodiscard]] double heat() const noexcept { return heat_.load(std::memory_order_relaxed); }
  /// How often the watchdog had to cut the device because no tick ended for kWatchdogSeconds. Once ticks come again the
  /// device is armed again and forces come back from zero. Any thread.
  [[nodiscard]] uint64_t watchdogCuts() const noexcept { return cuts_.load(); }
  /// How many faults there were: a reset on behalf of somebody who had seen fewer would undo a stop that nobody looked
  /// at. Any thread.
  [[nodiscard]] uint32_t faults() const noexcept { return tick_.safety().faults(); }
  /// Leaves a latched stop; the device's gate stays as it is. Only while the servo does not run.
  void reset() noexcept { tick_.reset(); }
  [[nodiscard]] double rateHz() const noexcept { return options_.rateHz; }
  /// Servo time, on which a tick begins as late as it does: ticks done, missed ones included, over the rate. It stands
  /// still while the servo does not run; only the motors cool then. Only while it does not run.
  [[nodiscard]] double timeS() const noexcept { return double(nextIndex_) / options_.rateHz; }

 private:
  void count(uint32_t flags) ARGIL_REALTIME;
  void loop();
  void watch();

  Device& device_;
  Options options_;
  SampleRing samples_;
  ServoTick tick_;
  std::unique_ptr<ServoStatistics> statistics_;
  enum class Copy : int { none, wanted, made };
  std::unique_ptr<ServoStatistics> copied_;  // The servo's while a copy is wanted, else the asker's.
  std::atomic<Copy> copy_{Copy::none};
  bool anyCopy_ = false;
  uint64_t nextIndex_ = 0;
  int64_t parkedNs_ = 0;  // When the paced thread ended; 0: never.
  std::thread thread_, watchdog_;
  RealtimeGrant grant_;  // Written by the thread before it says that it is ready.
  std::atomic<bool> ready_{false};
  std::atomic<bool> stop_{false};
  std::atomic<uint32_t> lastFlags_{kNoScene};
  std::atomic<bool> hung_{false};
  std::atomic<double> heat_{0};
  std::atomic<uint64_t> cuts_{0};
  Heartbeat heartbeat_;
};

}  // namespace argil::haptics
