// Whether a file is a document, by its first bytes: nothing is opened by SQLite for that.

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <system_error>

#include "io/bytes/input.h"
#include "io/bytes/replaced_file.h"
#include "io/records/document_facts.h"
#include "io/records/document_file.h"
#include "io/records/open_documents.h"

namespace argil::io {

void checkFile(const std::filesystem::path& path, const std::string& name) {
  struct stat facts {};
  if (::stat(path.c_str(), &facts) != 0) {
    if (errno == ENOENT || errno == ENOTDIR) fail(name, "there is no such file; check the name and the folder");
    fail(name, "cannot be opened (" + std::generic_category().message(errno) + "); check the name and the permissions");
  }
  if (S_ISDIR(facts.st_mode)) fail(name, "is a folder; name a file in it");
  if (!S_ISREG(facts.st_mode)) fail(name, "is not a regular file; name a document");
  if (::access(path.c_str(), R_OK) != 0)
    fail(name, "cannot be opened (" + std::generic_category().message(errno) + "); check its permissions");
  if (!isDocument(path))
    fail(name, "is not an Argil document, or its beginning is damaged; if it was one, recover what is whole in it");
}

bool isDocument(const std::filesystem::path& path) {
  const int fd = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK);
  if (fd < 0) return false;
  std::array<unsigned char, 100> header{};
  const ssize_t got = ::pread(fd, header.data(), header.size(), 0);
  closeKeepingLocks(fd);
  const uint32_t application =
      uint32_t{header[68]} << 24 | uint32_t{header[69]} << 16 | uint32_t{header[70]} << 8 | header[71];
  return got == static_cast<ssize_t>(header.size()) && std::memcmp(header.data(), "SQLite format 3", 16) == 0 &&
         application == kDocumentApplicationId;
}

}  // namespace argil::io
