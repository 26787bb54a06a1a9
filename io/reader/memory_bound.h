#pragma once
// The largest piece of memory that the reader process may take at once: a length that a damaged file claims is refused
// before memory is taken for it, whichever library believes it.

#include <atomic>
#include <cstddef>
#include <cstdint>

namespace argil::io::reader {

/// Bytes; `operator new` of the reader process throws std::bad_alloc beyond. Without effect in other programs.
inline std::atomic<size_t> mostAtOnce{SIZE_MAX};

/// Bounds each piece of memory while it lives.
class MemoryBound {
 public:
  explicit MemoryBound(size_t bytes) { mostAtOnce = bytes; }
  ~MemoryBound() { mostAtOnce = SIZE_MAX; }
  MemoryBound(const MemoryBound&) = delete;
  MemoryBound& operator=(const MemoryBound&) = delete;
};

}  // namespace argil::io::reader
