#pragma once
// STEP and IGES, read by OpenCASCADE: a library that is not always there.

#include <filesystem>

#include "io/reader/sender.h"

namespace argil::io::reader {

/// An object for each part of a .step or .iges file, placed, with its name and colour, in mm; faces as triangles.
/// Throws Error.
void readCad(const std::filesystem::path& file, Sender& sender);

}  // namespace argil::io::reader
