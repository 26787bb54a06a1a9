#include <unistd.h>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "ui3d/cli/verbs.h"

namespace argil::cli {

void bench(char** words) {
  std::error_code failed;
  const std::filesystem::path beside =
      std::filesystem::read_symlink("/proc/self/exe", failed).parent_path() / "argil-bench";
  if (!failed) ::execv(beside.c_str(), words);
  throw Error(fmt::format("bench: the program {} is not there; cmake --build --preset release --target argil-bench "
                          "makes it",
                          beside.string()),
              Error::Kind::input);
}

}  // namespace argil::cli
