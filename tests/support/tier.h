#pragma once
// How much of a test is done: a part in every run, all of it in the long tier.

#include <cstdlib>

namespace argil::tests {

/// ARGIL_LONG=1, as installer/test.sh --long sets it.
[[nodiscard]] inline bool longTier() {
  const char* word = std::getenv("ARGIL_LONG");
  return word != nullptr && *word == '1';
}

template <class Number>
[[nodiscard]] Number byTier(Number always, Number inLongTier) {
  return longTier() ? inLongTier : always;
}

}  // namespace argil::tests
