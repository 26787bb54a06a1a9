#pragma once
// Keeps the files that a command writes from replacing files that are there.

#include <filesystem>
#include <span>
#include <string>
#include <vector>

namespace argil::io {

using Files = std::vector<std::filesystem::path>;

/// Checks the names of outputs before the work begins; empty names are passed over. Throws Error, one line, for an
/// output that is an input (the same file by device and number, whatever links and spellings lead to it; `overwrite`
/// does not allow it), for two outputs of one name, and for an output that exists, unless `overwrite`. Files below the
/// folder that $XDG_STATE_HOME names are a program's own state and may be replaced. Devices, pipes and open files of
/// this process (/dev/stdout) may always be written; a folder is refused where it would be written.
void requireNewFiles(std::span<const std::filesystem::path> inputs, std::span<const std::filesystem::path> outputs,
                     bool overwrite);

/// Returns the files NAME + `between` + a number + `ending` (NAME-0001.obj) that exist beside `output`, NAME being its
/// name without ending; sorted.
[[nodiscard]] Files numberedBeside(const std::filesystem::path& output, const std::string& between,
                                   const std::string& ending);

/// Opens a character device, a pipe or an open file of this process (/dev/stdout, /dev/fd/3) for writing and returns
/// its descriptor; -1 for every other name. Waits at a named pipe until something reads it. Throws Error when it may
/// not be written.
[[nodiscard]] int openStream(const std::filesystem::path& name);

}  // namespace argil::io
