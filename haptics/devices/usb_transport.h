#pragma once
// A byte stream through libusb to a device behind an FTDI chip.

#include <memory>
#include <string>
#include <vector>

#include "haptics/devices/byte_transport.h"

namespace argil::haptics {

struct UsbPlace {
  std::string where;     ///< Bus and ports, "1-2.3": the same again when it is plugged into the same socket.
  bool usable = false;   ///< It can be opened by this user.
  std::string sentence;  ///< Why not, otherwise.
};

inline constexpr uint8_t kUsbOutEndpoint = 0x02;

/// Devices of that kind that are plugged in now. Throws Error when USB itself cannot be used.
[[nodiscard]] std::vector<UsbPlace> findUsb(uint16_t vendor, uint16_t product);

/// Interface 0, bulk OUT 0x02, bulk IN 0x81. Two IN transfers are always in flight, all transfers are allocated once,
/// and events are handled on the caller's thread: there is no other.
class UsbTransport final : public ByteTransport {
 public:
  /// `where`: the one in that place; empty: the first that nobody else uses. Throws Error when USB itself cannot be
  /// used.
  UsbTransport(uint16_t vendor, uint16_t product, std::string where);
  ~UsbTransport() override;

  Opening open() override;
  void close() noexcept override;
  [[nodiscard]] std::string sentence() const override;
  Transfer control(FtdiRequest request, uint16_t value) override;
  Transfer write(std::span<const uint8_t> bytes, int64_t timeoutNs) override;
  Transfer read(std::span<uint8_t> into, size_t& count, int64_t timeoutNs) override;
  [[nodiscard]] int file() const noexcept override;
  [[nodiscard]] bool clearToSend() const noexcept override;

 private:
  struct Usb;
  std::unique_ptr<Usb> usb_;
};

}  // namespace argil::haptics
