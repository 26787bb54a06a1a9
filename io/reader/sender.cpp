#include "io/reader/sender.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>

namespace argil::io::reader {

Sender::Sender() : buffer_(size_t{1} << 18) {
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
  for (size_t done = 0; done < used_;) {
    const ssize_t written = ::write(STDOUT_FILENO, buffer_.data() + done, used_ - done);
    if (written < 0 && errno == EINTR) continue;
    if (written <= 0) ::_exit(1);
    done += size_t(written);
  }
  used_ = 0;
}

void Sender::message(wire::Kind kind, std::span<const std::byte> first, std::span<const std::byte> second) {
  const wire::Head head{kind, uint32_t(first.size() + second.size())};
  put(std::as_bytes(std::span(&head, 1)));
  put(first);
  put(second);
}

}  // namespace argil::io::reader
