#include "io/input.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace argil::io {

namespace {

constexpr size_t kReadStep = size_t(4) << 20;
constexpr size_t kShownToken = 40;

std::string printable(std::string_view text) {
  std::string result;
  for (const char c : text) result += (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) ? '?' : c;
  return result;
}

std::string reason(int error) {
  return std::generic_category().message(error);
}

struct Descriptor {
  int fd;
  ~Descriptor() {
    if (fd >= 0) ::close(fd);
  }
};

}  // namespace

void fail(const std::string& name, const std::string& wrong) {
  throw Error(name + ": " + wrong);
}

std::string shown(std::string_view token) {
  const bool cut = token.size() > kShownToken;
  std::string result = printable(token.substr(0, kShownToken));
  // Bytes beyond ASCII may be anything in a damaged file: a terminal should not see them.
  for (char& c : result) {
    if (static_cast<unsigned char>(c) >= 0x80) c = '?';
  }
  return '"' + result + (cut ? "...\"" : "\"");
}

std::string displayName(const std::filesystem::path& path) {
  return printable(path.string());
}

FileBytes readFile(const std::filesystem::path& path, Job* job) {
  const std::string name = displayName(path);
  // Non-blocking, so that a pipe without a writer is refused instead of waited for.
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  if (file.fd < 0) {
    if (errno == ENOENT) fail(name, "there is no such file; check the name and the folder");
    fail(name, "cannot be opened (" + reason(errno) + "); check the name and the permissions");
  }
  struct stat facts {};
  if (::fstat(file.fd, &facts) != 0) fail(name, "cannot be examined (" + reason(errno) + ")");
  if (S_ISDIR(facts.st_mode)) fail(name, "is a folder; name a file in it");
  if (!S_ISREG(facts.st_mode)) fail(name, "is not a regular file; copy its content to a file first");
  if (facts.st_size == 0) fail(name, "is empty (0 bytes); export it again");
  FileBytes result;
  result.size = size_t(facts.st_size);
  try {
    result.data = std::make_unique_for_overwrite<std::byte[]>(result.size);
  } catch (const std::bad_alloc&) {
    fail(name, "is too large to be read into memory (" + std::to_string(result.size) + " bytes); reduce it first");
  }
  for (size_t done = 0; done < result.size;) {
    const ssize_t got = ::read(file.fd, result.data.get() + done, std::min(kReadStep, result.size - done));
    if (got < 0 && errno == EINTR) continue;
    if (got < 0) fail(name, "cannot be read (" + reason(errno) + ")");
    if (got == 0) fail(name, "became shorter while it was read; wait until it is written");
    done += size_t(got);
    if (job != nullptr) job->step(0.1 * double(done) / double(result.size));
  }
  return result;
}

}  // namespace argil::io
