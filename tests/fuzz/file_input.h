#pragma once
// A file that lives in memory, for readers that want a path.

#include <sys/mman.h>
#include <unistd.h>

#include <cstdint>
#include <filesystem>
#include <string>

#include "tests/fuzz/require.h"

namespace argil::tests {

class MemoryFile {
 public:
  MemoryFile() : file_(memfd_create("fuzz", MFD_CLOEXEC)) { require(file_ >= 0); }
  ~MemoryFile() { ::close(file_); }
  MemoryFile(const MemoryFile&) = delete;
  MemoryFile& operator=(const MemoryFile&) = delete;

  /// The path of a file that holds these bytes, until the next call.
  std::filesystem::path holding(const uint8_t* data, size_t size) {
    require(ftruncate(file_, 0) == 0 && (size == 0 || pwrite(file_, data, size, 0) == ssize_t(size)));
    return "/proc/self/fd/" + std::to_string(file_);
  }

 private:
  int file_;
};

}  // namespace argil::tests
