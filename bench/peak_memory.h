#pragma once
// How much memory some work took.

#include <algorithm>
#include <cstdint>
#include <fstream>
#include <string>

namespace argil::bench {

/// The most memory of the process since this was made, beside what was there then: what the system counts as resident.
/// Zero where it does not say. One at a time.
class PeakMemory {
 public:
  PeakMemory() {
    std::ofstream("/proc/self/clear_refs") << "5";
    before_ = read("VmRSS");
  }
  [[nodiscard]] uint64_t bytes() const {
    const uint64_t most = read("VmHWM");
    return most - std::min(most, before_);
  }

 private:
  static uint64_t read(const std::string& which) {
    std::ifstream status("/proc/self/status");
    for (std::string line; std::getline(status, line);)
      if (line.starts_with(which)) return 1024 * std::stoull(line.substr(which.size() + 1));
    return 0;
  }
  uint64_t before_ = 0;
};

}  // namespace argil::bench
