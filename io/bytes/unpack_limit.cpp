#include "io/bytes/unpack_limit.h"

#include <sys/resource.h>

#include <algorithm>
#include <fstream>

#include "io/bytes/input.h"

namespace argil::io {

namespace {

/// A line "NAME:   1234 kB" of a file of the kernel's; `otherwise` when there is none.
uint64_t bytesIn(const char* file, const std::string& name, uint64_t otherwise) {
  std::ifstream lines(file);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with(name)) return std::strtoull(line.c_str() + name.size(), nullptr, 10) * 1024;
  }
  return otherwise;
}

}  // namespace

uint64_t availableMemory() {
  uint64_t available = bytesIn("/proc/meminfo", "MemAvailable:", UINT64_MAX);
  rlimit space{};
  if (::getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY) {
    const uint64_t used = bytesIn("/proc/self/status", "VmSize:", 0);
    available = std::min<uint64_t>(available, space.rlim_cur - std::min<uint64_t>(space.rlim_cur, used));
  }
  return available;
}

void requireMemory(const std::string& name, uint64_t bytes) {
  if (bytes <= kFreeUnpacked) return;
  const uint64_t available = availableMemory();
  if (bytes > available / 2)
    fail(name, "unpacks to " + std::to_string(bytes >> 20) + " MiB, too much for the " +
                   std::to_string(available >> 20) +
                   " MiB of memory that are free; close other programs, or reduce it");
}

}  // namespace argil::io
