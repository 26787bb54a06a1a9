#include "tests/support/failing_writes.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <cstring>

namespace argil::failing {

namespace {

// Plain memory: calls come before constructors have run, and from any thread.
Plan plan;
char pathPart[256];
char told[256];
std::atomic<bool> armed{false};
std::atomic<long> calls{0};

void readEnvironment() {
  const char* text = std::getenv("ARGIL_FAIL");
  if (text == nullptr) return;
  Plan wanted;
  wanted.error = std::strncmp(text, "eio:", 4) == 0 ? EIO : ENOSPC;
  const char* number = std::strchr(text, ':');
  if (number == nullptr) return;
  wanted.from = std::strtol(number + 1, nullptr, 10);
  wanted.once = std::strstr(text, ":once") != nullptr;
  wanted.shortFirst = std::strstr(text, ":short") != nullptr;
  wanted.pathPart = std::getenv("ARGIL_FAIL_PATH");
  const char* file = std::getenv("ARGIL_FAIL_TOLD");
  if (file != nullptr) std::snprintf(told, sizeof told, "%s", file);
  begin(wanted);
}

const bool environmentWasRead = (readEnvironment(), true);

void tell() {
  if (told[0] == 0) return;
  const int fd = static_cast<int>(::syscall(SYS_openat, AT_FDCWD, told, O_WRONLY | O_CREAT | O_CLOEXEC, 0600));
  if (fd >= 0) ::close(fd);
}

/// Counts a call; true when it has to fail. `first` is set for the first one that does.
bool fails(const char* path, bool& first) {
  if (pathPart[0] != 0 && std::strstr(path, pathPart) == nullptr) return false;
  const long call = ++calls;
  first = call == plan.from;
  if (plan.error == 0 || call < plan.from || (plan.once && call > plan.from + (plan.shortFirst ? 1 : 0))) return false;
  if (first) tell();
  return true;
}

bool fails(int fd, bool& first) {
  first = false;
  if (!armed.load(std::memory_order_acquire)) return false;
  struct stat facts {};
  if (::fstat(fd, &facts) != 0 || (!S_ISREG(facts.st_mode) && !S_ISDIR(facts.st_mode))) return false;
  char link[64], path[512] = "";
  if (pathPart[0] != 0) {
    std::snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    const ssize_t size = ::readlink(link, path, sizeof path - 1);
    path[size < 0 ? 0 : size] = 0;
  }
  return fails(path, first);
}

bool failsPath(const char* from, const char* to) {
  bool first = false;
  if (!armed.load(std::memory_order_acquire)) return false;
  return fails(pathPart[0] != 0 && std::strstr(from, pathPart) == nullptr ? to : from, first);
}

long failed() {
  errno = plan.error;
  return -1;
}

/// The write of half, where the plan wants one.
bool takesHalf(bool first, size_t bytes) { return first && plan.shortFirst && bytes > 1; }

}  // namespace

void begin(const Plan& wanted) {
  armed = false;
  plan = wanted;
  pathPart[0] = 0;
  if (wanted.pathPart != nullptr) std::snprintf(pathPart, sizeof pathPart, "%s", wanted.pathPart);
  calls = 0;
  armed.store(true, std::memory_order_release);
}

long end() {
  armed = false;
  return calls;
}

}  // namespace argil::failing

using namespace argil::failing;

// Straight to the kernel: no other library's version of these functions is asked.
extern "C" {

ssize_t write(int fd, const void* bytes, size_t count) {
  bool first;
  if (!fails(fd, first)) return ::syscall(SYS_write, fd, bytes, count);
  return takesHalf(first, count) ? ::syscall(SYS_write, fd, bytes, count / 2) : failed();
}

ssize_t pwrite64(int fd, const void* bytes, size_t count, off64_t offset) {
  bool first;
  if (!fails(fd, first)) return ::syscall(SYS_pwrite64, fd, bytes, count, offset);
  return takesHalf(first, count) ? ::syscall(SYS_pwrite64, fd, bytes, count / 2, offset) : failed();
}

ssize_t pwrite(int fd, const void* bytes, size_t count, off_t offset) { return pwrite64(fd, bytes, count, offset); }

ssize_t writev(int fd, const iovec* parts, int count) {
  bool first;
  if (!fails(fd, first)) return ::syscall(SYS_writev, fd, parts, count);
  return takesHalf(first, static_cast<size_t>(count)) ? ::syscall(SYS_writev, fd, parts, count / 2) : failed();
}

int fsync(int fd) {
  bool first;
  if (fails(fd, first)) return static_cast<int>(failed());
  return armed && !plan.flushes ? 0 : static_cast<int>(::syscall(SYS_fsync, fd));
}

int fdatasync(int fd) {
  bool first;
  if (fails(fd, first)) return static_cast<int>(failed());
  return armed && !plan.flushes ? 0 : static_cast<int>(::syscall(SYS_fdatasync, fd));
}

int ftruncate64(int fd, off64_t length) noexcept {
  bool first;
  return static_cast<int>(fails(fd, first) ? failed() : ::syscall(SYS_ftruncate, fd, length));
}

int ftruncate(int fd, off_t length) noexcept { return ftruncate64(fd, length); }

int renameat2(int fromFolder, const char* from, int toFolder, const char* to, unsigned flags) noexcept {
  return static_cast<int>(failsPath(from, to) ? failed() : ::syscall(SYS_renameat2, fromFolder, from, toFolder, to, flags));
}

int rename(const char* from, const char* to) noexcept { return renameat2(AT_FDCWD, from, AT_FDCWD, to, 0); }

}  // extern "C"
