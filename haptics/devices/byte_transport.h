#pragma once
// What the Falcon's driver needs of a USB serial chip.

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>

namespace argil::haptics {

/// Vendor requests of the FTDI chip (type 0x40, index 0) and the values that the Falcon needs.
enum class FtdiRequest : uint8_t {
  reset = 0,
  modemLines = 1,
  flowControl = 2,
  baudDivisor = 3,
  lineFormat = 4,
  latencyTimer = 9
};
inline constexpr uint16_t kFtdiPurgeRx = 1, kFtdiPurgeTx = 2;
inline constexpr uint16_t kFtdiDtrOn = 0x0101, kFtdiDtrOff = 0x0100, kFtdiRtsOff = 0x0200;

enum class Transfer : uint8_t {
  ok,
  timeout,  ///< Nothing more went through in the time given.
  stall,    ///< The endpoint was halted and has been cleared: try again.
  gone,     ///< Unplugged or broken: close() and open() anew.
};

/// A byte stream to one device, with the modem-status bytes of its IN packets taken out. Calls come from one thread,
/// the device's own; they wait for their bus, at most as long as told. After a first open() reads and writes allocate
/// nothing.
class ByteTransport {
 public:
  virtual ~ByteTransport() = default;
  ByteTransport() = default;
  ByteTransport(const ByteTransport&) = delete;
  ByteTransport& operator=(const ByteTransport&) = delete;

  enum class Opening : uint8_t { opened, absent, refused };
  /// One try to open what is plugged in; refused when it is there and cannot be used.
  virtual Opening open() = 0;
  virtual void close() noexcept = 0;
  /// Of the last open(), for a person: where it is, or what is wrong and what to do.
  [[nodiscard]] virtual std::string sentence() const = 0;

  virtual Transfer control(FtdiRequest request, uint16_t value) = 0;
  /// At most 64 bytes, all or nothing.
  virtual Transfer write(std::span<const uint8_t> bytes, int64_t timeoutNs) = 0;
  /// Waits for at least one byte; `count` of them are in `into` when ok, none otherwise.
  virtual Transfer read(std::span<uint8_t> into, size_t& count, int64_t timeoutNs) = 0;
  /// The open file of /dev/bus/usb, for a guard that outlives this program; −1 where there is none.
  [[nodiscard]] virtual int file() const noexcept { return -1; }
  /// The clear-to-send line, as of the last packet read.
  [[nodiscard]] virtual bool clearToSend() const noexcept = 0;
};

/// What a packet of at most 64 bytes carries behind its two status bytes; `clearToSend` as it says, unchanged if too
/// short.
inline std::span<const uint8_t> withoutModemStatus(std::span<const uint8_t> packet, bool& clearToSend) noexcept {
  constexpr uint8_t kClearToSend = 0x10;
  if (packet.size() < 2) return {};
  clearToSend = (packet[0] & kClearToSend) != 0;
  return packet.subspan(2);
}

}  // namespace argil::haptics
