#pragma once
// How a target says that a promise was broken.

#include <cstdlib>
#include <cstring>

#include "clay/base/error.h"

namespace argil::tests {

inline void require(bool kept) {
  if (!kept) std::abort();
}

/// What is wrong with an input is told in one line.
inline void requireSentence(const Error& error, Error::Kind kind = Error::Kind::input) {
  require(error.kind() == kind && *error.what() != '\0' && std::strpbrk(error.what(), "\r\n") == nullptr);
}

}  // namespace argil::tests
