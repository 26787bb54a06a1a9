#pragma once
// The entries of a folder on the disk.

#include <filesystem>

namespace argil::io {

/// What was made, renamed or removed in `folder` before the call is on the disk when it returns 0 (fsync of the folder;
/// an empty path is the working folder). Otherwise returns the errno of the failure. A file system that cannot flush a
/// folder (EINVAL) and a folder that may not be opened for reading count as flushed: there is no other call to make.
/// Waits for the disk. Any thread.
[[nodiscard]] int flushFolder(const std::filesystem::path& folder);

}  // namespace argil::io
