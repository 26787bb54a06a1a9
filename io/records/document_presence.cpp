#include "io/records/document_presence.h"

#define XXH_INLINE_ALL
#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include <cinttypes>
#include <cstdio>
#include <string>
#include <system_error>

namespace argil::io {

namespace {

/// Whoever holds a lock alone does so for microseconds: to see whether it is alone.
constexpr int kAttempts = 20;
constexpr useconds_t kBetweenUs = 500;

std::string numbered(const char* format, uint64_t one, uint64_t two) {
  char text[64];
  std::snprintf(text, sizeof text, format, one, two);
  return text;
}

/// As create_directories, but for the user alone: what is open is nobody else's business.
void makePrivateFolder(const std::filesystem::path& folder) {
  if (folder.empty() || ::access(folder.c_str(), F_OK) == 0) return;
  if (folder.has_parent_path() && folder.parent_path() != folder) makePrivateFolder(folder.parent_path());
  (void)!::mkdir(folder.c_str(), 0700);
}

bool stillNamed(int fd, const std::filesystem::path& file) {
  struct stat open {
  }, named{};
  return ::fstat(fd, &open) == 0 && ::stat(file.c_str(), &named) == 0 && open.st_ino == named.st_ino &&
         open.st_dev == named.st_dev;
}

}  // namespace

DocumentPresence::DocumentPresence(const std::filesystem::path& document, const std::filesystem::path& folder) {
  makePrivateFolder(folder);
  std::error_code ignored;
  const std::filesystem::path whole =
      std::filesystem::weakly_canonical(std::filesystem::absolute(document, ignored), ignored);
  const std::string name = whole.empty() ? document.string() : whole.string();
  const XXH128_hash_t hash = XXH3_128bits(name.data(), name.size());
  announce(folder / numbered("path-%016" PRIx64 "%016" PRIx64, hash.high64, hash.low64));
  // O_PATH: closing it does not take the locks away that SQLite has on the file (see open_documents.h).
  pinned_ = ::open(document.c_str(), O_PATH | O_CLOEXEC);
  struct stat facts {};
  if (pinned_ >= 0 && ::fstat(pinned_, &facts) == 0)
    announce(folder / numbered("file-%" PRIx64 "-%" PRIx64, facts.st_dev, facts.st_ino));
}

// Every program that has the document open holds the lock together with the others; whoever gets it alone for a moment
// is the only one.
void DocumentPresence::announce(const std::filesystem::path& file) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600);
    if (fd < 0) return;
    const bool alone = ::flock(fd, LOCK_EX | LOCK_NB) == 0;
    // The lock that is held alone is given up for one that is shared; a file that the last one removed meanwhile locks
    // nobody out.
    if (::flock(fd, LOCK_SH | LOCK_NB) == 0 && stillNamed(fd, file)) {
      locks_.push_back({file, fd});
      elsewhere_ = elsewhere_ || !alone;
      return;
    }
    ::close(fd);
    ::usleep(kBetweenUs);
  }
}

// As announce() does it: who gets the lock alone for a moment is the only one. A lock that could not be had alone is
// gone (flock(2)) and is taken anew.
bool DocumentPresence::look() {
  bool elsewhere = false;
  for (const Lock& lock : locks_) {
    elsewhere = elsewhere || ::flock(lock.fd, LOCK_EX | LOCK_NB) != 0;
    if (!share(lock)) elsewhere = true;  // Somebody holds it alone: to see whether it is alone.
  }
  elsewhere_ = elsewhere;
  return elsewhere;
}

bool DocumentPresence::share(const Lock& lock) {
  for (int attempt = 0; attempt < kAttempts; ++attempt) {
    if (::flock(lock.fd, LOCK_SH | LOCK_NB) == 0) return true;
    ::usleep(kBetweenUs);
  }
  return false;
}

DocumentPresence::~DocumentPresence() {
  for (const Lock& lock : locks_) {
    // The last one removes the file; a crash leaves it, empty and without a lock.
    if (::flock(lock.fd, LOCK_EX | LOCK_NB) == 0 && stillNamed(lock.fd, lock.file)) ::unlink(lock.file.c_str());
    ::close(lock.fd);
  }
  if (pinned_ >= 0) ::close(pinned_);
}

}  // namespace argil::io
