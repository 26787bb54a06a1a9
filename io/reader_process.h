#pragma once
// Files that other people's libraries parse are parsed in a process of its own, which may die alone.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>

#include "clay/job.h"

namespace argil::io {

struct ReaderLimits {
  uint64_t memoryBytes = uint64_t{4} << 30;  ///< Address space of the process.
  double seconds = 120;                      ///< Of its CPU time, and twice that on the clock.
};

/// Starts `argil-reader WHAT FILE` (beside the running program, or what ARGIL_READER names) without forking, gives it the limits, lets it open nothing to write, and calls back with what it sends,
/// piece by piece. Throws Error with the sentence that the reader sent, or one that says that the file made it run out of memory, time or crash; Cancelled (it is
/// killed). Any thread but the servo's.
void runReader(const std::string& what, const std::filesystem::path& file, const std::function<void(std::span<const std::byte>)>& take, Job* job = nullptr,
               const ReaderLimits& limits = {});

}  // namespace argil::io
