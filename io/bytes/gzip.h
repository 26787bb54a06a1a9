#pragma once
// Files packed with gzip, in memory. For this module's files.

#include "io/bytes/input.h"

namespace argil::io {

[[nodiscard]] bool isGzip(const Input& input);

/// All members of the file (RFC 1952), one after the other. Throws Error for what is damaged or cut off, and as soon as
/// what has come out is beyond the limits (unpack_limit.h). Memory: what comes out; where several members hide how much
/// that is, two and a half times as much while it grows.
[[nodiscard]] FileBytes gunzipped(const Input& input);

}  // namespace argil::io
