#include "io/bytes/child_process.h"

#include <fcntl.h>
#include <sched.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "clay/base/error.h"
#include "io/bytes/input.h"

extern char** environ;

namespace argil::io {

namespace {

#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
constexpr bool kSanitized = true;
#else
constexpr bool kSanitized = false;
#endif
// Descriptors that a process may get lie below: copies of ours lie above, so that none is overwritten on its way.
constexpr int kAbove = 64;

/// A copy of a descriptor that lies above those of the process.
class Copy {
 public:
  explicit Copy(int fd) : fd_(fd < 0 ? -1 : ::fcntl(fd, F_DUPFD_CLOEXEC, kAbove)) {}
  ~Copy() {
    if (fd_ >= 0) ::close(fd_);
  }
  Copy(Copy&& other) noexcept : fd_(std::exchange(other.fd_, -1)) {}
  Copy& operator=(Copy&&) = delete;
  [[nodiscard]] int get() const { return fd_; }

 private:
  int fd_;
};

}  // namespace

ChildProcess::ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
                           std::span<const File> files) {
  posix_spawn_file_actions_t actions;
  ::posix_spawn_file_actions_init(&actions);
  std::vector<Copy> copies;
  int highest = STDERR_FILENO;
  const auto given = [&](int as) {
    return std::any_of(files.begin(), files.end(), [&](const File& each) { return each.as == as; });
  };
  for (const int standard : {STDIN_FILENO, STDOUT_FILENO, STDERR_FILENO})
    if (!given(standard) && !(standard == STDERR_FILENO && kSanitized))
      ::posix_spawn_file_actions_addopen(&actions, standard, "/dev/null", O_RDWR, 0);
  for (const File& each : files) {
    highest = std::max(highest, each.as);
    if (each.from < 0) {
      ::posix_spawn_file_actions_addopen(&actions, each.as, "/dev/null", O_RDWR, 0);
      continue;
    }
    copies.emplace_back(each.from);
    ::posix_spawn_file_actions_adddup2(&actions, copies.back().get(), each.as);
  }
  ::posix_spawn_file_actions_addclosefrom_np(&actions, highest + 1);
  posix_spawnattr_t attributes;
  ::posix_spawnattr_init(&attributes);
  sigset_t none, all;
  ::sigemptyset(&none);
  ::sigfillset(&all);
  ::posix_spawnattr_setsigmask(&attributes, &none);
  ::posix_spawnattr_setsigdefault(&attributes, &all);
  const sched_param ordinary{};
  ::posix_spawnattr_setschedpolicy(&attributes, SCHED_OTHER);
  ::posix_spawnattr_setschedparam(&attributes, &ordinary);
  ::posix_spawnattr_setflags(&attributes, POSIX_SPAWN_SETSIGMASK | POSIX_SPAWN_SETSIGDEF | POSIX_SPAWN_SETSCHEDULER);

  const std::string name = program.string();
  std::vector<char*> words{const_cast<char*>(name.c_str())};
  for (const std::string& argument : arguments) words.push_back(const_cast<char*>(argument.c_str()));
  words.push_back(nullptr);
  const int failed = ::posix_spawn(&pid_, name.c_str(), &actions, &attributes, words.data(), environ);
  ::posix_spawnattr_destroy(&attributes);
  ::posix_spawn_file_actions_destroy(&actions);
  if (failed == 0) return;
  pid_ = -1;
  throw Error(
      "the program " + displayName(program) + " cannot be started (" + std::strerror(failed) + "); install argil again",
      Error::Kind::work);
}

ChildProcess::~ChildProcess() {
  kill();
  if (pid_ > 0) static_cast<void>(wait());
}

void ChildProcess::kill() {
  if (pid_ > 0 && !status_) ::kill(pid_, SIGKILL);
}

int ChildProcess::wait() {
  int status = 0;
  while (!status_) {
    if (::waitpid(pid_, &status, 0) == pid_)
      status_ = status;
    else if (errno != EINTR)
      status_ = 0;  // somebody else has waited for it
  }
  return *status_;
}

std::optional<int> ChildProcess::ended() {
  int status = 0;
  if (!status_ && ::waitpid(pid_, &status, WNOHANG) == pid_) status_ = status;
  return status_;
}

std::filesystem::path programBeside(const char* name, const char* named, const char* purpose) {
  if (const char* chosen = std::getenv(named); chosen != nullptr && *chosen != '\0') {
    if (::access(chosen, X_OK) == 0) return chosen;
    throw Error("the program " + displayName(chosen) + ", which " + named + " names, is not there: " + purpose +
                    "; name " + name + " or unset the variable",
                Error::Kind::work);
  }
  std::error_code failed;
  const std::filesystem::path beside = std::filesystem::read_symlink("/proc/self/exe", failed).parent_path() / name;
  if (!failed && ::access(beside.c_str(), X_OK) == 0) return beside;
  throw Error("the program " + displayName(beside) + " is not there: " + purpose +
                  "; install argil again or name it in " + named,
              Error::Kind::work);
}

}  // namespace argil::io
