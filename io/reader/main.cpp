// argil-reader: parses one file with somebody else's library, checks it, and sends what is in it to standard output
// (wire.h).
//   argil-reader gltf|draco|vdb|grey|colour FILE [MEMORY-BYTES SECONDS [PIXELS]]
// FILE "-": what it is given as its standard input. PIXELS: the most along an edge of a picture.

#include <fcntl.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <new>

#include "io/reader/memory_bound.h"
#include "io/reader/reader.h"
#include "io/reader/run.h"

#if !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
void* operator new(size_t bytes) {
  void* const memory = bytes <= argil::io::reader::mostAtOnce ? std::malloc(bytes == 0 ? 1 : bytes) : nullptr;
  if (memory == nullptr) throw std::bad_alloc();
  return memory;
}
void operator delete(void* memory) noexcept {
  std::free(memory);
}
void operator delete(void* memory, size_t) noexcept {
  std::free(memory);
}
#endif

namespace argil::io::reader {

void tryForbidden(const std::filesystem::path& file, Sender& sender) {
  const std::string target = file.string() + ".forbidden";
  if (::open(target.c_str(), O_WRONLY | O_CREAT, 0600) >= 0) sender.note("a file was opened to write");
  if (::open(file.c_str(), O_RDWR) >= 0) sender.note("the file was opened to write");
  if (::rename(file.c_str(), target.c_str()) == 0) sender.note("the file was renamed");
  if (::unlink(file.c_str()) == 0) sender.note("the file was removed");
  const int other = ::open((file.string() + ".other").c_str(), O_RDONLY);
  if (other >= 0) sender.note("another file was opened");
  if (::kill(::getppid(), 0) == 0) sender.note("another process could be sent a signal");
  if (::syscall(SYS_tgkill, ::getppid(), ::getppid(), 0) == 0)
    sender.note("a thread of another process could be sent a signal");
  if (::socket(AF_UNIX, SOCK_STREAM, 0) >= 0) sender.note("a socket was opened");
  const pid_t child = ::fork();
  if (child == 0) ::_exit(0);
  if (child > 0) sender.note("a process was started");
  sender.note("all was tried");
  ::execl("/bin/true", "true", nullptr);  // whose empty stream is the note
}

}  // namespace argil::io::reader

int main(int argc, char** argv) {
  using namespace argil::io::reader;
  static constexpr std::array<Reads, 6> kTable{{
      // It keeps its buffers in its folder.
      {"gltf", [](const auto& file, int, Sender& sender) { readGltf(file, sender); }, true},
      {"draco", [](const auto& file, int, Sender& sender) { readDraco(file, sender); }},
      {"vdb", [](const auto& file, int, Sender& sender) { readVdb(file, sender); }},
      {"grey",
       [](const auto& file, int largest, Sender& sender) { readPicture(file, PictureAs::grey, largest, sender); }},
      {"colour",
       [](const auto& file, int largest, Sender& sender) { readPicture(file, PictureAs::colour, largest, sender); }},
      {"forbidden", [](const auto& file, int, Sender& sender) { tryForbidden(file, sender); }},
  }};
  run(argc, argv, kTable);
}
