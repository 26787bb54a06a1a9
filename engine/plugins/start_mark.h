#pragma once
// Whether the last start with plugins came to an end that nobody wanted.

#include <filesystem>

#include "io/sandbox/descriptor.h"

namespace argil::engine {

/// A file that says "a start is under way", from its making to good() or its end. What is left of a process that died
/// meanwhile is found by the next start; another window's start beside this one is no such thing.
class StartMark {
 public:
  /// Empty, or no right to write there: nothing is marked, and nothing is known.
  explicit StartMark(const std::filesystem::path& file);
  ~StartMark() { good(); }
  StartMark(const StartMark&) = delete;
  StartMark& operator=(const StartMark&) = delete;

  [[nodiscard]] bool lastDied() const { return lastDied_; }
  /// The start is over.
  void good();

 private:
  io::Descriptor file_;
  bool holds_ = false, lastDied_ = false;
};

}  // namespace argil::engine
