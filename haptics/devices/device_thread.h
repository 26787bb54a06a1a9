#pragma once
// What all drivers of hardware share: a thread for each device, states, reconnecting, zero force when anything is
// wrong.

#include <atomic>
#include <memory>
#include <mutex>
#include <semaphore>
#include <string>
#include <thread>

#include "haptics/base/device.h"
#include "haptics/servo/force_line.h"
#include "haptics/threads/delay_meter.h"
#include "haptics/threads/latest_value.h"

namespace argil::haptics {

/// One kind of hardware at the other end of a cable. Only the device's thread calls it; it may wait, on its own I/O
/// alone, and never throws.
class DeviceLink {
 public:
  virtual ~DeviceLink() = default;
  DeviceLink() = default;
  DeviceLink(const DeviceLink&) = delete;
  DeviceLink& operator=(const DeviceLink&) = delete;

  enum class Opened { ready, absent, refused };
  /// Finds the device and greets it. Anything but `ready` leaves nothing open and says in `sentence` what is wrong and
  /// what to do; with `ready` the sentence says where it is. May take a second.
  virtual Opened open(std::string& sentence) = 0;

  enum class Exchanged { state, nothing, garbage, gone };
  /// Sends `forceN` (N, device's frame, finite, within the sheet) and waits for an answer until `deadlineNs` of
  /// nowNs(). `nothing`: no answer in time; `garbage`: one that cannot be one; `gone`: unplugged. `state` counts only
  /// with `state`.
  virtual Exchanged exchange(const Vec3d& forceN, int64_t deadlineNs, DeviceState& state) noexcept = 0;

  /// Sends zero force as well as it still can and closes. Idempotent.
  virtual void close() noexcept = 0;
};

enum class DeviceCondition : uint8_t { absent, opening, ready, faulted, unplugged };

/// A device behind a link. Its thread exchanges at the device's rate, above the servo's priority where that is granted.
/// It sends zero until the first good answer; while its gate is shut; after a bad or missing answer until the next good
/// one; when the servo wrote nothing for kWatchdogSeconds; and on the way out. Commands from before a stop never
/// return, nor does the force after an exchange that came kStallSeconds late, since the guard may have zeroed the
/// motors: the servo begins anew. No force is longer than the sheet's peak. Nothing good for kSilentSeconds: closed and
/// opened anew; one that was unplugged is looked for every kRetrySeconds.
class ThreadedDevice final : public Device {
 public:
  static constexpr double kRetrySeconds = 0.1;
  static constexpr double kSilentSeconds = 0.1;

  struct Options {
    double lateSeconds = 0;  ///< An answer older than this is late; 0: four exchanges at the sheet's rate.
    bool realtime = true;    ///< Ask for SCHED_FIFO.
    int priority = 85;       ///< Above the servo and its watchdog.
    /// In virtual time: no thread, whoever made it calls begin() and end(); the link is never used.
    bool manual = false;
  };

  /// Starts at once; a device that is not there yet is used as soon as it is.
  ThreadedDevice(DeviceSheet sheet, std::unique_ptr<DeviceLink> link, const Options& options);
  ThreadedDevice(DeviceSheet sheet, std::unique_ptr<DeviceLink> link)
      : ThreadedDevice(std::move(sheet), std::move(link), Options()) {}
  /// Zero force, then closed.
  ~ThreadedDevice() override;

  [[nodiscard]] const DeviceSheet& sheet() const noexcept override { return sheet_; }
  bool read(double timeS, DeviceState& state) ARGIL_REALTIME override;
  void write(double timeS, const Vec3d& forceN) ARGIL_REALTIME override;
  [[nodiscard]] std::string status() const override;
  /// Measured: the median of some hundred cycles from command to state and back. Two exchanges until then.
  [[nodiscard]] double delayS() const ARGIL_REALTIME override { return sheet_.dofOut > 0 ? delay_.delayS() : 0; }

  // The device's side of an exchange: its own thread calls them, or whoever turns it in virtual time (Options::manual).

  /// The force to send now, at `nowNs`: of the servo, or zero.
  [[nodiscard]] Vec3d begin(int64_t nowNs);
  /// What the exchange that began last ended with at `nowNs`. `where`: what to say when it is ready.
  void end(DeviceLink::Exchanged result, const DeviceState& state, int64_t nowNs, const std::string& where = {});

  // Any thread.
  [[nodiscard]] DeviceCondition condition() const noexcept { return condition_.load(); }
  /// Good ones.
  [[nodiscard]] uint64_t exchanges() const noexcept { return exchanges_.load(std::memory_order_relaxed); }
  /// Bad or missing answers.
  [[nodiscard]] uint64_t failures() const noexcept { return failures_.load(std::memory_order_relaxed); }

 private:
  struct Answer {
    DeviceState state;
    int64_t atNs = 0;
    int64_t beganNs = 0;  // Its exchange.
    // Of the command that was sent with it, from the servo to its first exchange; below zero: none was.
    int64_t lagNs = -1;
  };
  struct Sentence {
    char text[240] = {};
  };

  void run();
  void serve(const std::string& where);
  void tell(DeviceCondition condition, const std::string& sentence);
  [[nodiscard]] int64_t servoNs(double timeS) const ARGIL_REALTIME;

  DeviceSheet sheet_;
  std::unique_ptr<DeviceLink> link_;
  Options options_;
  int64_t periodNs_, lateNs_, stallNs_;
  LatestValue<Answer> answers_;  // Device thread to servo.
  ForceLine forces_;             // Servo to device thread.
  mutable LatestValue<Sentence> sentence_;
  mutable std::mutex readers_;  // Of the sentence, among themselves: the device's thread never waits for them.
  Answer answer_;               // The servo's.
  DelayMeter delay_;            // The servo adds to it.
  // The device's thread's, while it serves.
  bool answering_ = false;
  int64_t beganNs_ = 0, lastWrittenNs_ = 0, lagNs_ = -1;
  std::atomic<bool> live_{false}, stop_{false};
  std::atomic<DeviceCondition> condition_{DeviceCondition::opening};
  std::atomic<uint64_t> exchanges_{0}, failures_{0};
  std::binary_semaphore stopping_{0};
  std::thread thread_;
};

}  // namespace argil::haptics
