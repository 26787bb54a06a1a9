#pragma once
// Objects that an editor has at hand. This module's own.

#include <cstddef>
#include <vector>

namespace argil::clay {

/// Free objects that an editor took from its store, with room for all that it ever took: what comes back needs no
/// memory.
struct ObjectStock {
  std::vector<void*> free;
  size_t taken = 0;
};

}  // namespace argil::clay
