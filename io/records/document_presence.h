#pragma once
// Who has a document open.

#include <filesystem>
#include <vector>

namespace argil::io {

/// Announces to other programs of this user that a document is open here, and tells whether one of them has it open as
/// well. It is known by its path and by its inode, so that links to it count as the same document. Advice alone: what
/// keeps documents apart is the stamp of each save (document_file.h).
///
/// The announcement is a lock (flock) on an empty file in `folder`: it ends with the program however that ends, and
/// nothing has to be written where the document is. Where the folder cannot be written, nothing is announced and nobody
/// is found. One thread.
class DocumentPresence {
 public:
  /// Makes the folder where it is missing. Never throws and never waits for longer than some milliseconds.
  DocumentPresence(const std::filesystem::path& document, const std::filesystem::path& folder);
  ~DocumentPresence();
  DocumentPresence(const DocumentPresence&) = delete;
  DocumentPresence& operator=(const DocumentPresence&) = delete;

  /// Returns whether somebody else, in this program too, had the document open when this was made or last looked.
  [[nodiscard]] bool elsewhere() const { return elsewhere_; }
  /// Looks again; returns elsewhere(). Some microseconds, during which another program may find nobody here.
  bool look();

 private:
  struct Lock {
    std::filesystem::path file;
    int fd = -1;
  };
  void announce(const std::filesystem::path& file);
  static bool share(const Lock& lock);

  std::vector<Lock> locks_;
  int pinned_ = -1;  ///< The document itself, so that no other file gets its inode meanwhile.
  bool elsewhere_ = false;
};

}  // namespace argil::io
