#pragma once
// A system that refuses threads or memory, for the program that refusing_system.cpp is linked to.

namespace argil::tests {

/// While it stands no thread can be begun, but for `first` ones.
class NoThreads {
 public:
  explicit NoThreads(int first = 0);
  ~NoThreads();
  NoThreads(const NoThreads&) = delete;
  NoThreads& operator=(const NoThreads&) = delete;
  /// How many were refused.
  [[nodiscard]] static int refused();
};

/// While it stands there is no aligned memory for the thread that made it, but for `first` blocks.
class NoAlignedMemory {
 public:
  explicit NoAlignedMemory(int first = 0);
  ~NoAlignedMemory();
  NoAlignedMemory(const NoAlignedMemory&) = delete;
  NoAlignedMemory& operator=(const NoAlignedMemory&) = delete;
};

}  // namespace argil::tests
