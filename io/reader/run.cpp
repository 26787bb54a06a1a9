#include "io/reader/run.h"

#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <new>
#include <stdexcept>
#include <string>

#include "clay/base/error.h"
#include "io/sandbox/sandbox.h"

namespace argil::io::reader {

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
void run(int argc, char** argv, std::span<const Reads> table) {
  if (argc < 3) {
    std::fprintf(stderr, "%s is started by argil: %s WHAT FILE [MEMORY-BYTES SECONDS [PIXELS]]\n", argv[0], argv[0]);
    ::_exit(2);
  }
  const std::string_view what = argv[1];
  const std::filesystem::path file = argv[2];
  Sender sender;
  try {
    limitResources({.memoryBytes = argc > 3 ? std::strtoull(argv[3], nullptr, 10) : uint64_t{4} << 30,
                    .cpuSeconds = argc > 4 ? std::strtoull(argv[4], nullptr, 10) : 120,
                    .endsWithParentThread = true});
    const auto row = std::find_if(table.begin(), table.end(), [&](const Reads& each) { return each.what == what; });
    const std::string unconfined = confine(row != table.end() && row->folder ? file.parent_path() : file);
    if (!unconfined.empty()) sender.note(unconfined);
    if (row == table.end()) throw Error("the reader does not know the format " + std::string(what), Error::Kind::work);
    row->read(file, argc > 5 ? std::atoi(argv[5]) : 1024, sender);
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

}  // namespace argil::io::reader
