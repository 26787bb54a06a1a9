#include "io/bytes/output_files.h"

#include <fcntl.h>
#include <fmt/format.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <optional>
#include <set>
#include <string_view>
#include <system_error>
#include <utility>

#include "clay/base/error.h"
#include "io/bytes/input.h"

namespace argil::io {

namespace fs = std::filesystem;

namespace {

// Looks at the file that a name leads to, links followed; nothing where there is none.
std::optional<struct stat> fileAt(const fs::path& name) {
  struct stat found {};
  if (name.empty() || ::stat(name.c_str(), &found) != 0) return std::nullopt;
  return found;
}

bool isSame(const struct stat& a, const struct stat& b) {
  return a.st_dev == b.st_dev && a.st_ino == b.st_ino;
}

// Resolves links and dots as far as there are files.
fs::path resolved(const fs::path& name) {
  std::error_code error;
  const fs::path whole = fs::weakly_canonical(fs::absolute(name, error), error);
  return error ? name.lexically_normal() : whole;
}

// Reads the number of an open file of this process from its name; nothing for other names.
std::optional<int> descriptorOf(const fs::path& name) {
  const std::string text = name.lexically_normal().string();
  if (text == "/dev/stdout") return STDOUT_FILENO;
  if (text == "/dev/stderr") return STDERR_FILENO;
  for (const std::string_view folder : {"/dev/fd/", "/proc/self/fd/"}) {
    if (!text.starts_with(folder)) continue;
    int number = 0;
    const char* const end = text.data() + text.size();
    const auto [at, error] = std::from_chars(text.data() + folder.size(), end, number);
    if (error == std::errc() && at == end && number >= 0) return number;
  }
  return std::nullopt;
}

// Decides whether a file lies below the folder of programs' state, where that is named.
bool isState(const fs::path& file) {
  const char* const named = std::getenv("XDG_STATE_HOME");
  if (!named || !fs::path(named).is_absolute()) return false;  // A relative one is void: XDG Base Directory, 0.8.
  fs::path state = resolved(fs::path(named));
  if (!state.has_filename()) state = state.parent_path();
  const fs::path whole = resolved(file);
  const auto [inState, inFile] = std::mismatch(state.begin(), state.end(), whole.begin(), whole.end());
  return inState == state.end() && inFile != whole.end();
}

}  // namespace

void requireNewFiles(std::span<const fs::path> inputs, std::span<const fs::path> outputs, bool overwrite) {
  std::vector<std::pair<fs::path, struct stat>> read;
  for (const fs::path& input : inputs)
    if (const auto found = fileAt(input)) read.emplace_back(input, *found);
  std::set<fs::path> names;
  for (const fs::path& output : outputs) {
    if (output.empty() || descriptorOf(output)) continue;
    const std::optional<struct stat> there = fileAt(output);
    if (there && !S_ISREG(there->st_mode)) continue;
    for (const auto& [input, found] : read)
      if (there && isSame(*there, found))
        throw Error(fmt::format("{}: is the input {}; give the output another name", displayName(output),
                                input == output ? "itself" : displayName(input)));
    if (!names.insert(resolved(output)).second)
      throw Error(fmt::format("{}: is named for two outputs; give each its own name", displayName(output)));
    if (there && !overwrite && !isState(output))
      throw Error(
          fmt::format("{}: exists already; give --overwrite to replace it, or another name", displayName(output)));
  }
}

Files numberedBeside(const fs::path& output, const std::string& between, const std::string& ending) {
  Files files;
  const std::string begin = output.stem().string() + between;
  std::error_code error;
  const fs::path folder = output.has_parent_path() ? output.parent_path() : fs::path(".");
  for (fs::directory_iterator at(folder, error), end; !error && at != end; at.increment(error)) {
    const std::string name = at->path().filename().string();
    if (name.size() <= begin.size() + ending.size() || !name.starts_with(begin) || !name.ends_with(ending)) continue;
    const std::string number = name.substr(begin.size(), name.size() - begin.size() - ending.size());
    if (number.find_first_not_of("0123456789") == std::string::npos) files.push_back(output.parent_path() / name);
  }
  std::sort(files.begin(), files.end());
  return files;
}

int openStream(const fs::path& name) {
  int fd = -1;
  if (const std::optional<int> descriptor = descriptorOf(name)) {
    fd = ::fcntl(*descriptor, F_DUPFD_CLOEXEC, 0);
  } else {
    const std::optional<struct stat> there = fileAt(name);
    if (!there || !(S_ISCHR(there->st_mode) || S_ISFIFO(there->st_mode))) return -1;
    fd = ::open(name.c_str(), O_WRONLY | O_CLOEXEC);
  }
  if (fd < 0)
    throw Error(fmt::format("{}: may not be written ({}); choose another name", displayName(name),
                            std::generic_category().message(errno)));
  return fd;
}

}  // namespace argil::io
