#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>

#include "clay/base/error.h"
#include "io/reader/reader.h"
#include "io/sandbox/descriptor.h"

namespace argil::io::reader {

std::vector<unsigned char> contentOf(const std::filesystem::path& file, uint64_t most) {
  const Descriptor opened(file == kInput ? -1 : ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK));
  const int fd = file == kInput ? STDIN_FILENO : opened.get();
  if (fd < 0) throw Error("cannot be opened; check the name and the permissions");
  struct stat facts {};
  if (::fstat(fd, &facts) != 0 || !S_ISREG(facts.st_mode))
    throw Error("is not a regular file; copy its content to a file first");
  if (facts.st_size == 0) throw Error("is empty (0 bytes); export it again");
  if (uint64_t(facts.st_size) > most)
    throw Error("is larger than " + std::to_string(most >> 20) + " MiB; split it first");
  std::vector<unsigned char> bytes(size_t(facts.st_size), 0);
  for (size_t done = 0; done < bytes.size();) {
    const ssize_t got = ::pread(fd, bytes.data() + done, bytes.size() - done, off_t(done));
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) throw Error("cannot be read to its end; wait until it is written");
    done += size_t(got);
  }
  return bytes;
}

}  // namespace argil::io::reader
