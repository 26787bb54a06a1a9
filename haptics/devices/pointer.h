#pragma once
// A mouse or a pen as a stylus: the window feeds it, no force comes back.

#include <atomic>
#include <deque>
#include <limits>

#include "haptics/base/device.h"
#include "haptics/threads/sample_ring.h"

namespace argil::haptics {

/// What the window knows of a mouse or a pen at one moment, in the device's frame.
struct PointerSample {
  Vec3d origin = Vec3d::Zero();  ///< mm; the eye, or any point on the line of sight through the cursor.
  Vec3d direction = {0, 0, -1};  ///< Of the line of sight; need not be of length one.
  /// From the origin to the surface under the cursor along it, mm. Not finite: nothing is under it; the last depth
  /// stays. While a stroke lasts let it be the surface as it was when the stroke began, or the tip follows its own cut
  /// for ever deeper.
  double surfaceMm = std::numeric_limits<double>::quiet_NaN();
  double wheel = 0;             ///< Clicks since the window opened, away from the person positive: deeper.
  float pressure = -1;          ///< 0 to 1; negative where the thing cannot tell, as a mouse.
  double tiltX = 0, tiltY = 0;  ///< Of a pen, to the right and towards the person, rad, within ± 1.5.
  uint32_t buttons = 0;
};

struct PointerOptions {
  double wheelStepMm = 0.25;  ///< A click of the wheel takes the tip so much deeper: 0 to 100.
  double penDepthMm = 3;      ///< Full pressure takes the tip so far under the surface: 0 to 100.
  /// Events come 60 to 1000 times a second: time in which two thirds of a step are done. 0 to 0.1.
  double smoothSeconds = 0.004;
};

/// The tip is on the line of sight, at the depth of the surface, plus wheel, plus pressure. It goes there smoothly,
/// however far that is: nobody holds it, so no speed is a fault.
///
/// Samples are followed in their order, so that a stroke arrives whole when the window or the servo is late and several
/// wait: while a button is held each of them has a tick of its own (motions without a button are skipped over), and a
/// button changes only once the tip has come to the point before the change.
class PointerDevice final : public Device {
 public:
  /// Throws Error for options out of range.
  explicit PointerDevice(const PointerOptions& options);
  PointerDevice() : PointerDevice(PointerOptions()) {}

  /// The window's thread only; never waits. While nobody reads, 1024 samples are kept and then 256 changes of the
  /// buttons. False, and nothing changes, when a number that must be finite is not or the direction is zero.
  bool feed(const PointerSample& sample) noexcept;
  /// The pen left its tablet, or the cursor its window: read() is false until the next feed(). The window's thread.
  void leave() noexcept;

  [[nodiscard]] const DeviceSheet& sheet() const noexcept override { return sheet_; }
  bool read(double timeS, DeviceState& state) ARGIL_REALTIME override;
  void write(double, const Vec3d&) ARGIL_REALTIME override {}
  [[nodiscard]] std::string status() const override;

 private:
  DeviceSheet sheet_;
  PointerOptions options_;
  struct Fed {
    DeviceState state;
    bool present = false;
  };
  void send(const Fed& fed) noexcept;
  // Whether `next` may be followed in a tick that has already followed `followed` samples.
  [[nodiscard]] bool takes(const Fed& next, int followed, size_t waiting) const ARGIL_REALTIME;

  BoundedRing<Fed> fed_;
  // The window's.
  std::deque<Fed> late_;  // What the ring had no room for; motions with the same buttons are one.
  double surfaceMm_ = 0;  // The last depth of a surface under the cursor.
  std::atomic<bool> present_{false};
  // The servo's.
  Fed wanted_, next_;
  bool hasNext_ = false;
  int waitedTicks_ = 0;  // for the tip to arrive before the buttons change
  DeviceState now_;
  double lastS_ = 0;
  bool moving_ = false;
};

}  // namespace argil::haptics
