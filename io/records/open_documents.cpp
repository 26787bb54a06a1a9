#include "io/records/open_documents.h"

#include <sys/stat.h>
#include <unistd.h>

#include <map>
#include <mutex>
#include <utility>
#include <vector>

namespace argil::io {

namespace {

struct Entry {
  int documents = 0;
  std::vector<int> waiting;  ///< Descriptors to close with the last one.
};

std::mutex mutex;

/// By device and inode.
std::map<std::pair<dev_t, ino_t>, Entry>& entries() {
  static std::map<std::pair<dev_t, ino_t>, Entry> all;
  return all;
}

}  // namespace

OpenDocument::OpenDocument(const std::filesystem::path& path) {
  struct stat facts {};
  if (::stat(path.c_str(), &facts) == 0) {
    device_ = facts.st_dev;
    inode_ = facts.st_ino;
  }
  const std::lock_guard lock(mutex);
  ++entries()[{device_, inode_}].documents;
}

OpenDocument::~OpenDocument() {
  const std::lock_guard lock(mutex);
  const auto entry = entries().find({device_, inode_});
  if (--entry->second.documents > 0) return;
  for (const int fd : entry->second.waiting) ::close(fd);
  entries().erase(entry);
}

bool OpenDocument::isStill(const std::filesystem::path& path) const {
  struct stat facts {};
  return ::stat(path.c_str(), &facts) == 0 && facts.st_dev == device_ && facts.st_ino == inode_;
}

void closeKeepingLocks(int fd) {
  struct stat facts {};
  const bool known = ::fstat(fd, &facts) == 0;
  const std::lock_guard lock(mutex);
  const auto entry = known ? entries().find({facts.st_dev, facts.st_ino}) : entries().end();
  if (entry == entries().end()) {
    ::close(fd);
  } else {
    entry->second.waiting.push_back(fd);
  }
}

}  // namespace argil::io
