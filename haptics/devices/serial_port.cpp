#include "haptics/devices/serial_port.h"

#include <fcntl.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <termios.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

#include "haptics/base/clock.h"

namespace argil::haptics {

SerialPort::Opened SerialPort::open(const std::string& path, std::string& sentence) {
  close();
  const int fd = ::open(path.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (fd < 0) {
    const bool absent = errno == ENOENT || errno == ENXIO || errno == ENODEV;
    sentence = absent ? "not plugged in (" + path + ")"
                      : path + " cannot be opened (" + std::strerror(errno) + ")" +
                            (errno == EACCES ? ": install installer/99-argil.rules or join the group dialout" : "");
    return absent ? Opened::absent : Opened::refused;
  }
  termios line{};
  if (tcgetattr(fd, &line) != 0) {
    sentence = path + " is no serial line; name the one of the device, such as /dev/ttyACM0";
    ::close(fd);
    return Opened::refused;
  }
  cfmakeraw(&line);
  line.c_cflag |= CLOCAL | CREAD;
  line.c_cflag &= ~static_cast<tcflag_t>(CRTSCTS | CSTOPB);
  line.c_cc[VMIN] = 0;
  line.c_cc[VTIME] = 0;
  cfsetspeed(&line, B115200);
  if (tcsetattr(fd, TCSANOW, &line) != 0 || ioctl(fd, TIOCEXCL) != 0) {
    sentence = path + " cannot be set up (" + std::strerror(errno) + "); unplug the device and plug it in again";
    ::close(fd);
    return Opened::refused;
  }
  tcflush(fd, TCIOFLUSH);
  fd_ = fd;
  return Opened::ready;
}

void SerialPort::close() noexcept {
  if (fd_ < 0) return;
  ioctl(fd_, TIOCNXCL);
  ::close(fd_);
  fd_ = -1;
}

int SerialPort::read(std::span<uint8_t> bytes, int64_t deadlineNs) noexcept {
  if (fd_ < 0) return -1;
  while (true) {
    const ssize_t n = ::read(fd_, bytes.data(), bytes.size());
    if (n > 0) return static_cast<int>(n);
    if (n < 0 && errno != EAGAIN && errno != EINTR) return -1;
    const int64_t left = deadlineNs - nowNs();
    if (left <= 0) return 0;
    pollfd p{fd_, POLLIN, 0};
    const timespec t{static_cast<time_t>(left / 1'000'000'000), static_cast<long>(left % 1'000'000'000)};
    if (ppoll(&p, 1, &t, nullptr) <= 0 || !(p.revents & (POLLHUP | POLLERR | POLLNVAL))) continue;
    // Hung up: what is left is read. poll() would go on to answer at once, and read() to find nothing, until the
    // deadline.
    const ssize_t rest = ::read(fd_, bytes.data(), bytes.size());
    return rest > 0 ? static_cast<int>(rest) : -1;
  }
}

int SerialPort::readAll(std::span<uint8_t> bytes, int64_t deadlineNs) noexcept {
  while (!bytes.empty()) {
    const int n = read(bytes, deadlineNs);
    if (n <= 0) return n;
    bytes = bytes.subspan(static_cast<size_t>(n));
  }
  return 1;
}

int SerialPort::write(std::span<const uint8_t> bytes) noexcept {
  if (fd_ < 0) return -1;
  while (!bytes.empty()) {
    const ssize_t n = ::write(fd_, bytes.data(), bytes.size());
    if (n < 0 && errno == EINTR) continue;
    if (n < 0) return errno == EAGAIN ? 0 : -1;
    bytes = bytes.subspan(static_cast<size_t>(n));
  }
  return 1;
}

bool SerialPort::discardInput() noexcept {
  if (fd_ < 0) return true;
  uint8_t scrap[256];
  for (size_t taken = 0; taken < kMostDiscarded; taken += sizeof scrap)
    if (::read(fd_, scrap, sizeof scrap) <= 0) return true;
  return false;
}

}  // namespace argil::haptics
