#pragma once
// What stood under a name before a new file takes it.

#include <sys/stat.h>

#include <cstdint>
#include <filesystem>

namespace argil::io {

/// What a new file is going to replace, to be told from what others put there meanwhile.
struct Replaced {
  bool there = false;
  dev_t device = 0;
  ino_t inode = 0;
  off_t bytes = 0;
  timespec changed{};
  uint64_t stamp = 0;  ///< Of a document that can be read.

  /// What stands at the path now.
  static Replaced at(const std::filesystem::path& path) {
    Replaced now;
    struct stat facts {};
    if (::stat(path.c_str(), &facts) != 0) return now;
    return {true, facts.st_dev, facts.st_ino, facts.st_size, facts.st_mtim, 0};
  }
  [[nodiscard]] bool isStill(const Replaced& now) const {
    return there == now.there && device == now.device && inode == now.inode && bytes == now.bytes &&
           changed.tv_sec == now.changed.tv_sec && changed.tv_nsec == now.changed.tv_nsec;
  }
};

}  // namespace argil::io
