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

/// Rounds of a test that damages things by chance: as many as ARGIL_ROUNDS says, for a soak.
[[nodiscard]] inline int rounds(int always, int inLongTier) {
  const char* word = std::getenv("ARGIL_ROUNDS");
  return word != nullptr ? std::atoi(word) : byTier(always, inLongTier);
}

}  // namespace argil::tests
