#pragma once
// A USB bus that does not exist, for programs started under umockdev-wrapper: libusb sees what is plugged in here as it
// sees hardware.

#include <memory>
#include <string>

#include "falcon_emulator.h"

namespace argil::haptics::testing {

/// One bus at a time. Functional only: an exchange takes most of a millisecond, and waiting for one burns a core.
class EmulatedUsb {
 public:
  /// Throws std::runtime_error when the program was not started under umockdev-wrapper.
  EmulatedUsb();
  ~EmulatedUsb();
  EmulatedUsb(const EmulatedUsb&) = delete;
  EmulatedUsb& operator=(const EmulatedUsb&) = delete;

  /// Into the socket `port` of bus 1, "2" for the place "1-2". The emulator must outlive the bus.
  void plug(FalconEmulator& emulator, const std::string& port);
  /// Of that socket. What programs still hold open answers that there is no device.
  void unplug(const std::string& port);

 private:
  struct Bus;
  std::unique_ptr<Bus> bus_;
};

}  // namespace argil::haptics::testing
