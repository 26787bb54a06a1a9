#pragma once
// Files packed with gzip, in memory. For this room's files.

#include "io/input.h"

namespace argil::io {

[[nodiscard]] bool isGzip(const Input& input);

/// All members of the file (RFC 1952), one after the other. Throws Error for what is damaged or cut off, for more than
/// 4 GiB, and beyond 64 MiB for more than 200 bytes from a packed one. Memory: what comes out, twice at most while its
/// size is not known.
[[nodiscard]] FileBytes gunzipped(const Input& input);

}  // namespace argil::io
