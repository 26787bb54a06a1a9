#pragma once
// What every program that reads for argil does around it: limits, confinement, and the last word.

#include <filesystem>
#include <span>
#include <string_view>

#include "io/reader/sender.h"

namespace argil::io::reader {

/// One of the things that a program reads.
struct Reads {
  std::string_view what;
  /// `largest`: pixels along an edge, of pictures. Throws Error, a sentence without the file's name.
  void (*read)(const std::filesystem::path& file, int largest, Sender& sender);
  bool folder = false;  ///< The file's folder may be read too.
};

/// PROGRAM WHAT FILE [MEMORY-BYTES SECONDS [PIXELS]]; FILE "-": what it is given as its standard input. Ends the
/// process.
[[noreturn]] void run(int argc, char** argv, std::span<const Reads> table);

}  // namespace argil::io::reader
