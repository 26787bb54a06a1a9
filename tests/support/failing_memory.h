#pragma once
// Memory that is not there when it is asked for the n-th time, for the program that failing_memory.cpp is linked to.

#include <cstddef>

namespace argil::tests {

/// Whether operator new is this program's own: not where a sanitizer has it.
[[nodiscard]] bool memoryCanFail();

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
