#pragma once
// How much of a test is done: a part in every run, all of it in the long tier.

#include <cstdint>
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

/// Of such a test: ARGIL_SEED, so that a second soak damages other places than the first.
[[nodiscard]] inline uint32_t seed(uint32_t usual) {
  const char* word = std::getenv("ARGIL_SEED");
  return word != nullptr ? static_cast<uint32_t>(std::strtoul(word, nullptr, 10)) : usual;
}

}  // namespace argil::tests
