#pragma once
// A recorded hand as a device: it goes where the hand went, whatever it is told.

#include <atomic>
#include <string>

#include "haptics/base/device.h"
#include "haptics/devices/hand_path.h"

namespace argil::haptics {

/// Plays a hand path in servo time from the first read() on. Before a loop begins anew, and after the end of a path
/// that does not loop, read() is false: the servo starts gently where the path jumps. No force out.
class RecordedDevice final : public Device {
 public:
  struct Options {
    std::string name = "recorded";  ///< Begins its status.
    bool loop = false;
  };
  /// Throws Error for an empty path. The sheet's workspace and top speed are the path's.
  RecordedDevice(HandPath path, Options options);

  [[nodiscard]] const DeviceSheet& sheet() const noexcept override { return sheet_; }
  bool read(double timeS, DeviceState& state) ARGIL_REALTIME override;
  void write(double, const Vec3d&) ARGIL_REALTIME override {}
  [[nodiscard]] std::string status() const override;

 private:
  DeviceSheet sheet_;
  HandPath path_;
  Options options_;
  bool started_ = false;
  double startS_ = 0;
  size_t hint_ = 0;
  std::atomic<double> playedS_{0};
  std::atomic<bool> ended_{false};
};

}  // namespace argil::haptics
