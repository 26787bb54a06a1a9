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

#include <cerrno>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <new>
#include <stdexcept>
#include <string_view>

#include "clay/base/error.h"
#include "io/reader/reader.h"
#include "io/sandbox/sandbox.h"

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

namespace {

// No file but `readable`, no calls but those of reading. A sentence for the user where the system can do only one of
// the two, or neither.
std::string confine(const std::filesystem::path& readable) {
  if (kConfinesNothing) return {};
  const bool files = confineFiles(std::span(&readable, 1)), calls = confineCalls(Calls::reading);
  if (files && calls) return {};
  const std::string cannot = "this system cannot confine the program that reads such files";
  if (calls)
    return cannot + " to this one (it has no Landlock): it could read others of yours if a damaged file misled it";
  if (files) return cannot + " fully (it has no seccomp): open only files that you trust";
  return cannot + " (it has neither seccomp nor Landlock): open only files that you trust";
}

}  // namespace
}  // namespace argil::io::reader

int main(int argc, char** argv) {
  using namespace argil;
  using namespace argil::io;
  if (argc < 3) {
    std::fputs(
        "argil-reader is started by argil: argil-reader gltf|draco|vdb|grey|colour FILE [MEMORY-BYTES SECONDS "
        "[PIXELS]]\n",
        stderr);
    return 2;
  }
  const std::string_view what = argv[1];
  const std::filesystem::path file = argv[2];
  reader::Sender sender;
  try {
    limitResources({.memoryBytes = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : uint64_t{4} << 30,
                    .cpuSeconds = argc > 4 ? std::strtoull(argv[4], nullptr, 10) : 120,
                    .endsWithParentThread = true});
    // glTF keeps its buffers in its folder.
    const std::string unconfined = reader::confine(what == "gltf" ? file.parent_path() : file);
    if (!unconfined.empty()) sender.note(unconfined);
    if (what == "gltf") {
      reader::readGltf(file, sender);
    } else if (what == "draco") {
      reader::readDraco(file, sender);
    } else if (what == "vdb") {
      reader::readVdb(file, sender);
    } else if (what == "grey" || what == "colour") {
      reader::readPicture(file, what == "grey" ? reader::PictureAs::grey : reader::PictureAs::colour,
                          argc > 5 ? std::atoi(argv[5]) : 1024, sender);
    } else if (what == "forbidden") {
      reader::tryForbidden(file, sender);
    } else {
      throw Error("the reader does not know the format " + std::string(what), Error::Kind::work);
    }
    sender.plain(wire::Kind::end);
  } catch (const Error& error) {
    sender.text(wire::Kind::error, error.what());
  } catch (const std::bad_alloc&) {
    sender.plain(wire::Kind::memory);
  } catch (const std::length_error&) {
    sender.plain(wire::Kind::memory);
  } catch (const std::exception& error) {
    sender.text(wire::Kind::error, std::string("is damaged (") + error.what() + "); export it again");
  }
  sender.flush();
  ::_exit(0);  // what the libraries hold is not worth destroying
}
