#pragma once
// What the device was sent, and how long it took.

#include <cstdint>

namespace argil::render {

/// What one update sent to the device.
struct UploadStats {
  uint64_t bytes = 0;        ///< Vertices and indices written.
  uint64_t copiedBytes = 0;  ///< Moved on the device because a buffer grew.
  uint64_t writes = 0;       ///< Ranges written.
};

/// Time that the device spent on each pass of the last picture, µs, in the order drawn; empty where it has no clock.
struct PassTime {
  const char* name = "";
  double us = 0;
};

}  // namespace argil::render
