#include "tests/support/failing_writes.h"
#include "tests/support/write_trace.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdarg>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <string>

namespace argil::failing {

namespace {

// Plain memory: calls come before constructors have run, and from any thread.
Plan plan;
char pathPart[256];
char told[256];
std::atomic<bool> armed{false};
std::atomic<long> calls{0};

std::atomic<int> slowFlushMs{0};

void readEnvironment() {
  if (const char* ms = std::getenv("ARGIL_SLOW_FLUSH_MS")) slowFlushMs = std::atoi(ms);
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
bool takesHalf(bool first, size_t bytes) {
  return first && plan.shortFirst && bytes > 1;
}

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
namespace {

/// Done and, where it succeeded, written down.
template <class Call, class Told>
long traced(const Call& call, const Told& told) {
  const tracing::Guard guard;
  const long result = call();
  if (guard.on() && result >= 0) told(result);
  return result;
}

long openWith(int folder, const char* path, int flags, mode_t mode) {
  return traced([&] { return ::syscall(SYS_openat, folder, path, flags, mode); },
                [&](long fd) { tracing::opened(folder, path, flags, static_cast<int>(fd)); });
}

/// No flush is waited for while calls are only counted or traced.
int flushWith(long number, int fd) {
  bool first;
  if (fails(fd, first)) return static_cast<int>(failed());
  const bool waits = !armed || plan.flushes;
  if (slowFlushMs > 0) ::usleep(static_cast<useconds_t>(slowFlushMs) * 1000);
  return static_cast<int>(
      traced([&] { return waits ? ::syscall(number, fd) : 0L; }, [&](long) { tracing::flushed(fd); }));
}

mode_t modeOf(int flags, va_list more) {
  return (flags & (O_CREAT | O_TMPFILE)) != 0 ? static_cast<mode_t>(va_arg(more, int)) : 0;
}

}  // namespace

extern "C" {

ssize_t write(int fd, const void* bytes, size_t count) {
  bool first;
  const bool failing = fails(fd, first);
  if (failing && !takesHalf(first, count)) return failed();
  return traced([&] { return ::syscall(SYS_write, fd, bytes, failing ? count / 2 : count); },
                [&](long done) { tracing::wroteBeforePosition(fd, bytes, static_cast<size_t>(done)); });
}

ssize_t pwrite64(int fd, const void* bytes, size_t count, off64_t offset) {
  bool first;
  const bool failing = fails(fd, first);
  if (failing && !takesHalf(first, count)) return failed();
  return traced([&] { return ::syscall(SYS_pwrite64, fd, bytes, failing ? count / 2 : count, offset); },
                [&](long done) { tracing::wrote(fd, bytes, static_cast<size_t>(done), offset); });
}

ssize_t pwrite(int fd, const void* bytes, size_t count, off_t offset) {
  return pwrite64(fd, bytes, count, offset);
}

ssize_t writev(int fd, const iovec* parts, int count) {
  bool first;
  const bool failing = fails(fd, first);
  if (failing && !takesHalf(first, static_cast<size_t>(count))) return failed();
  return traced([&] { return ::syscall(SYS_writev, fd, parts, failing ? count / 2 : count); },
                [&](long done) {
                  std::string all;
                  for (int i = 0; i < count; ++i)
                    all.append(static_cast<const char*>(parts[i].iov_base), parts[i].iov_len);
                  tracing::wroteBeforePosition(fd, all.data(), static_cast<size_t>(done));
                });
}

int fsync(int fd) {
  return flushWith(SYS_fsync, fd);
}

int fdatasync(int fd) {
  return flushWith(SYS_fdatasync, fd);
}

int ftruncate64(int fd, off64_t length) noexcept {
  bool first;
  if (fails(fd, first)) return static_cast<int>(failed());
  return static_cast<int>(traced([&] { return ::syscall(SYS_ftruncate, fd, length); },
                                 [&](long) { tracing::resized(fd, static_cast<uint64_t>(length)); }));
}

int ftruncate(int fd, off_t length) noexcept {
  return ftruncate64(fd, length);
}

int truncate64(const char* path, off64_t length) noexcept {
  return static_cast<int>(traced([&] { return ::syscall(SYS_truncate, path, length); },
                                 [&](long) { tracing::resizedPath(AT_FDCWD, path, static_cast<uint64_t>(length)); }));
}

int truncate(const char* path, off_t length) noexcept {
  return truncate64(path, length);
}

int renameat2(int fromFolder, const char* from, int toFolder, const char* to, unsigned flags) noexcept {
  if (failsPath(from, to)) return static_cast<int>(failed());
  return static_cast<int>(traced([&] { return ::syscall(SYS_renameat2, fromFolder, from, toFolder, to, flags); },
                                 [&](long) { tracing::renamed(fromFolder, from, toFolder, to); }));
}

int rename(const char* from, const char* to) noexcept {
  return renameat2(AT_FDCWD, from, AT_FDCWD, to, 0);
}

// These are traced but never fail on purpose.

int open(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = modeOf(flags, more);
  va_end(more);
  return static_cast<int>(openWith(AT_FDCWD, path, flags, mode));
}

int open64(const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = modeOf(flags, more);
  va_end(more);
  return static_cast<int>(openWith(AT_FDCWD, path, flags, mode));
}

int openat(int folder, const char* path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = modeOf(flags, more);
  va_end(more);
  return static_cast<int>(openWith(folder, path, flags, mode));
}

int creat(const char* path, mode_t mode) {
  return static_cast<int>(openWith(AT_FDCWD, path, O_CREAT | O_WRONLY | O_TRUNC, mode));
}

int mkdir(const char* path, mode_t mode) noexcept {
  return static_cast<int>(traced([&] { return ::syscall(SYS_mkdirat, AT_FDCWD, path, mode); },
                                 [&](long) { tracing::madeFolder(AT_FDCWD, path); }));
}

int unlinkat(int folder, const char* path, int flags) noexcept {
  return static_cast<int>(traced([&] { return ::syscall(SYS_unlinkat, folder, path, flags); },
                                 [&](long) { tracing::unlinked(folder, path); }));
}

int unlink(const char* path) noexcept {
  return unlinkat(AT_FDCWD, path, 0);
}

int rmdir(const char* path) noexcept {
  return unlinkat(AT_FDCWD, path, AT_REMOVEDIR);
}

int remove(const char* path) noexcept {
  const int result = unlinkat(AT_FDCWD, path, 0);
  return result != 0 && errno == EISDIR ? rmdir(path) : result;
}

}  // extern "C"
