#pragma once
// operator new of a test program's own, for the program that own_new.cpp is linked to: it counts, and fails when it is
// asked to.

#include <cstddef>

namespace argil::tests {

/// Whether operator new is this program's own: not where a sanitizer has it.
[[nodiscard]] bool memoryCanFail();

/// How often this thread allocated so far; 0 where memoryCanFail() is false.
[[nodiscard]] size_t allocations();

/// While it stands the `nth` allocation (from 1 on) of the thread that made it throws std::bad_alloc, and every later
/// one too if `forGood`.
class FailingMemory {
 public:
  explicit FailingMemory(size_t nth, bool forGood = false);
  ~FailingMemory();
  FailingMemory(const FailingMemory&) = delete;
  FailingMemory& operator=(const FailingMemory&) = delete;
  /// Whether one was refused.
  [[nodiscard]] bool refused() const;
};

}  // namespace argil::tests
