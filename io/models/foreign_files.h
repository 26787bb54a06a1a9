#pragma once
// Files that people try and that are no models. For this module's files.

#include <string>

#include "io/bytes/input.h"

namespace argil::io {

/// "is a STEP model; export it as STL ...": what the content surely is, and what to do; empty when it is not known.
[[nodiscard]] std::string whatForeignFileIs(const Input& input);

}  // namespace argil::io
