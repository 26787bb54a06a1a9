// Whether a file is a document, by its first bytes: nothing is opened by SQLite for that.

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cstring>

#include "io/bytes/replaced_file.h"
#include "io/records/document_facts.h"
#include "io/records/document_file.h"

namespace argil::io {

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
