#include "io/reader/sender.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <utility>

namespace argil::io::reader {

namespace {

constexpr size_t kBufferBytes = size_t{1} << 18;

void toStandardOutput(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t written = ::write(STDOUT_FILENO, bytes.data(), bytes.size());
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) ::_exit(1);
    bytes = bytes.subspan(size_t(written));
  }
}

}  // namespace

Sender::Sender() : Sender(toStandardOutput) {}

Sender::Sender(std::function<void(std::span<const std::byte>)> listener)
    : listener_(std::move(listener)), buffer_(kBufferBytes) {
  put(std::as_bytes(std::span(wire::kMagic)));
}

void Sender::put(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const size_t part = std::min(bytes.size(), buffer_.size() - used_);
    std::memcpy(buffer_.data() + used_, bytes.data(), part);
    used_ += part;
    bytes = bytes.subspan(part);
    if (used_ == buffer_.size()) flush();
  }
}

void Sender::flush() {
  listener_({buffer_.data(), used_});
  used_ = 0;
}

void Sender::message(wire::Kind kind, std::span<const std::byte> first, std::span<const std::byte> second) {
  const wire::Head head{kind, uint32_t(first.size() + second.size())};
  put(std::as_bytes(std::span(&head, 1)));
  put(first);
  put(second);
}

}  // namespace argil::io::reader
