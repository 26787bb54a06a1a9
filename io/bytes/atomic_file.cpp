#include "io/bytes/atomic_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdio>
#include <system_error>
#include <utility>

#include "clay/base/error.h"
#include "io/bytes/folder_flush.h"
#include "io/bytes/input.h"
#include "io/bytes/output_files.h"

namespace argil::io {

namespace {

/// Names tried before giving up; a clash needs another program that uses the same names.
constexpr int kNamesTried = 100;
/// Of the target's name, so that the temporary one stays within the 255 bytes of a file name.
constexpr size_t kNameKept = 180;

std::string reason(int error) {
  return std::generic_category().message(error);
}

[[noreturn]] void failWork(const std::filesystem::path& target, const std::string& wrong) {
  throw Error(displayName(target) + ": " + wrong, Error::Kind::work);
}

std::filesystem::path temporaryName(const std::filesystem::path& target) {
  static std::atomic<uint64_t> counter{0};
  const auto now = uint64_t(std::chrono::steady_clock::now().time_since_epoch().count());
  return target.parent_path() /
         ("." + target.filename().string().substr(0, kNameKept) + "." + std::to_string(::getpid()) + "-" +
          std::to_string(now % 1000000007) + "-" + std::to_string(counter++) + ".tmp");
}

/// As rename(): -1 and errno.
int putInPlace(const std::filesystem::path& from, const std::filesystem::path& to, bool mayReplace) {
  if (mayReplace) return ::rename(from.c_str(), to.c_str());
  if (::renameat2(AT_FDCWD, from.c_str(), AT_FDCWD, to.c_str(), RENAME_NOREPLACE) == 0) return 0;
  if (errno != EINVAL && errno != ENOSYS) return -1;
  // Some file systems know no such rename: another program can then come in between for a moment.
  struct stat there {};
  if (::lstat(to.c_str(), &there) == 0) {
    errno = EEXIST;
    return -1;
  }
  return ::rename(from.c_str(), to.c_str());
}

}  // namespace

AtomicFile::AtomicFile(const std::filesystem::path& target) : target_(target) {
  const std::string name = displayName(target);
  if (target.filename().empty() || target.filename() == "." || target.filename() == "..") {
    fail(name, "does not name a file to write; add a file name");
  }
  // A device or a pipe keeps its place: it has no temporary file, and what is written is gone.
  fd_ = openStream(target);
  if (fd_ >= 0) return;
  std::error_code error;
  // Renaming over a link would replace the link and leave the file that it names as it was.
  if (std::filesystem::is_symlink(target, error)) {
    target_ = std::filesystem::weakly_canonical(target, error);
    if (error) fail(name, "is a link that cannot be followed (" + error.message() + "); name the file itself");
  }
  struct stat old {};
  const bool replaces = ::stat(target_.c_str(), &old) == 0;
  if (!replaces && errno != ENOENT && errno != ENOTDIR) {
    fail(name, "cannot be written (" + reason(errno) + "); choose another name");
  }
  if (replaces) {
    if (S_ISDIR(old.st_mode)) fail(name, "is a folder; name a file in it");
    if (!S_ISREG(old.st_mode)) fail(name, "is not a regular file; name a file to write");
    if (::access(target_.c_str(), W_OK) != 0)
      fail(name, "may not be written (" + reason(errno) + "); choose another name");
  }
  for (int attempt = 0; fd_ < 0; ++attempt) {
    temporary_ = temporaryName(target_);
    fd_ = ::open(temporary_.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0666);
    if (fd_ >= 0 || (errno == EEXIST && attempt < kNamesTried)) continue;
    if (errno == ENOENT || errno == ENOTDIR)
      fail(name, "its folder does not exist; create the folder or choose another");
    fail(name, "its folder cannot be written (" + reason(errno) + "); choose another");
  }
  // Best effort: some file systems know no permissions.
  if (replaces && ::fchmod(fd_, old.st_mode & 07777) != 0) errno = 0;
}

AtomicFile::~AtomicFile() {
  if (fd_ >= 0) ::close(fd_);
  if (!temporary_.empty()) ::unlink(temporary_.c_str());
}

void AtomicFile::write(std::span<const std::byte> bytes) {
  while (!bytes.empty()) {
    const ssize_t done = ::write(fd_, bytes.data(), bytes.size());
    if (done < 0 && errno == EINTR) continue;
    if (done < 0) failWork(target_, "cannot be written (" + reason(errno) + "); make room or choose another folder");
    bytes_ += uint64_t(done);
    bytes = bytes.subspan(size_t(done));
  }
}

void AtomicFile::commit(bool mayReplace) {
  if (temporary_.empty()) {
    if (::close(std::exchange(fd_, -1)) != 0)
      failWork(target_, "cannot be written (" + reason(errno) + "); make room or choose another folder");
    return;
  }
  // The data must be on the disk before the name is, or a crash could leave the new name with nothing behind it.
  if (::fsync(fd_) != 0) failWork(target_, "cannot be flushed to the disk (" + reason(errno) + ")");
  const int fd = std::exchange(fd_, -1);
  if (::close(fd) != 0) failWork(target_, "cannot be closed (" + reason(errno) + ")");
  if (putInPlace(temporary_, target_, mayReplace) != 0) {
    if (errno == EEXIST) failWork(target_, "was made by another program meanwhile; choose another name");
    failWork(target_, "cannot be put in place (" + reason(errno) + "); choose another name");
  }
  temporary_.clear();
  // Until then a power cut may bring the old name back, so nobody may be told that it is safe.
  if (const int error = flushFolder(target_.parent_path()); error != 0) {
    failWork(target_, "is written, but its folder cannot be flushed to the disk (" + reason(error) +
                          "), so a power cut may lose it; write it to another disk too");
  }
}

}  // namespace argil::io
