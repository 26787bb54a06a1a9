#pragma once
// A serial line as raw bytes.

#include <cstdint>
#include <span>
#include <string>

namespace argil::haptics {

/// Owns the file descriptor of a terminal in raw mode. One thread. Nothing throws.
class SerialPort {
 public:
  SerialPort() = default;
  ~SerialPort() { close(); }
  SerialPort(const SerialPort&) = delete;
  SerialPort& operator=(const SerialPort&) = delete;

  enum class Opened { ready, absent, refused };
  /// 115200 baud, 8N1, no flow control (a CDC ACM device takes no notice of the speed), for this process alone.
  /// Otherwise `sentence` says what is wrong and what to do.
  Opened open(const std::string& path, std::string& sentence);
  void close() noexcept;
  [[nodiscard]] bool isOpen() const noexcept { return fd_ >= 0; }
  /// -1 while closed.
  [[nodiscard]] int fd() const noexcept { return fd_; }

  /// Number of bytes read, as many as came at once, at least one; 0 when none came by `deadlineNs` of nowNs(); -1 when
  /// the device is gone.
  [[nodiscard]] int read(std::span<uint8_t> bytes, int64_t deadlineNs) noexcept;
  /// Exactly `bytes.size()` bytes: 1, or 0 when they did not come by then, or -1 when the device is gone.
  [[nodiscard]] int readAll(std::span<uint8_t> bytes, int64_t deadlineNs) noexcept;
  /// All of it without waiting: 1; 0 when the line takes no more just now; -1 when the device is gone.
  [[nodiscard]] int write(std::span<const uint8_t> bytes) noexcept;
  /// Throws away what came and was not read yet, kMostDiscarded bytes at most: false when there may be more, as from a
  /// device that talks without end.
  bool discardInput() noexcept;
  static constexpr size_t kMostDiscarded = 4096;  ///< A terminal's whole queue.

 private:
  int fd_ = -1;
};

}  // namespace argil::haptics
