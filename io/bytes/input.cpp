#include "io/bytes/input.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>
#include <cctype>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <system_error>

namespace argil::io {

namespace {

constexpr size_t kReadStep = size_t(4) << 20;
constexpr size_t kShownToken = 40;
constexpr size_t kLongestName = 200;

/// Bytes of the well-formed UTF-8 character that begins `text`; 0 when none does (Unicode 15, table 3-7).
size_t utf8Length(std::string_view text) {
  const auto byte = [&text](size_t i) { return i < text.size() ? static_cast<unsigned char>(text[i]) : 0u; };
  const auto in = [&byte](size_t i, unsigned low, unsigned high) { return byte(i) >= low && byte(i) <= high; };
  const unsigned first = byte(0);
  if (first < 0x80) return text.empty() ? 0 : 1;
  if (first >= 0xc2 && first <= 0xdf) return in(1, 0x80, 0xbf) ? 2 : 0;
  if (first >= 0xe0 && first <= 0xef) {
    const bool second = in(1, first == 0xe0 ? 0xa0 : 0x80, first == 0xed ? 0x9f : 0xbf);
    return second && in(2, 0x80, 0xbf) ? 3 : 0;
  }
  if (first >= 0xf0 && first <= 0xf4) {
    const bool second = in(1, first == 0xf0 ? 0x90 : 0x80, first == 0xf4 ? 0x8f : 0xbf);
    return second && in(2, 0x80, 0xbf) && in(3, 0x80, 0xbf) ? 4 : 0;
  }
  return 0;
}

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

std::string headOf(const std::filesystem::path& path) {
  constexpr size_t kHead = 4096;
  const Descriptor file{::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)};
  struct stat facts {};
  if (file.fd < 0 || ::fstat(file.fd, &facts) != 0 || !S_ISREG(facts.st_mode)) return {};
  std::string head(kHead, '\0');
  const ssize_t got = ::pread(file.fd, head.data(), head.size(), 0);
  head.resize(got > 0 ? size_t(got) : 0);
  return head;
}

std::string_view withoutMark(std::string_view text) {
  constexpr std::string_view kMark = "\xef\xbb\xbf";
  return text.starts_with(kMark) ? text.substr(kMark.size()) : text;
}

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

std::string endingOf(const std::filesystem::path& path) {
  std::string ending = path.extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(), [](unsigned char c) { return char(std::tolower(c)); });
  return ending;
}

std::string displayName(const std::filesystem::path& path) {
  return printable(path.string());
}

std::string cleanName(std::string_view text) {
  constexpr std::string_view kBlanks = " \t\v\f\r\n";
  const size_t begin = text.find_first_not_of(kBlanks);
  if (begin == std::string_view::npos) return {};
  text = text.substr(begin, text.find_last_not_of(kBlanks) + 1 - begin);
  std::string result;
  while (!text.empty()) {
    const size_t length = utf8Length(text);
    const bool shownAsIs = length > 1 || (length == 1 && text[0] >= 0x20 && text[0] != 0x7f);
    const std::string_view piece = shownAsIs ? text.substr(0, length) : "?";
    if (result.size() + piece.size() > kLongestName) break;
    result += piece;
    text.remove_prefix(std::max<size_t>(length, 1));
  }
  return result;
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
