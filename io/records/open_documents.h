#pragma once
// Locks that this process holds on its documents, kept from being lost.

#include <sys/types.h>

#include <filesystem>

namespace argil::io {

/// POSIX lets go of all locks that a process has on a file when it closes any descriptor of that file, and SQLite's
/// locks are of that kind (fcntl(2), "Advisory record locking"; sqlite.org/howtocorrupt.html, 2.2). So whoever else
/// reads a file that may be an open document closes it by closeKeepingLocks(). Any thread.
class OpenDocument {
 public:
  /// The file is there; before SQLite opens it.
  explicit OpenDocument(const std::filesystem::path& path);
  /// After SQLite has closed it.
  ~OpenDocument();
  OpenDocument(const OpenDocument&) = delete;
  OpenDocument& operator=(const OpenDocument&) = delete;

  /// False when the path now leads to another file, or to none.
  [[nodiscard]] bool isStill(const std::filesystem::path& path) const;

 private:
  dev_t device_ = 0;
  ino_t inode_ = 0;
};

/// Closes it now, or when the last OpenDocument of its file goes.
void closeKeepingLocks(int fd);

}  // namespace argil::io
