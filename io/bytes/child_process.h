#pragma once
// A program of ours that runs other people's code, as a process of its own.

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace argil::io {

/// Started by posix_spawn, because a fork would copy the page tables of a program that holds gigabytes and a servo;
/// without our files, signals and real-time class. Killed and waited for when this goes.
class ChildProcess {
 public:
  /// A descriptor of ours and what the process has it as; −1: /dev/null. What it prints goes nowhere, but for the
  /// reports of sanitizers, unless a File says where.
  struct File {
    int from = -1;
    int as = 0;
  };
  /// `arguments`: the words after the program's name. Throws Error (work) when it cannot be started.
  ChildProcess(const std::filesystem::path& program, const std::vector<std::string>& arguments,
               std::span<const File> files);
  ~ChildProcess();
  ChildProcess(const ChildProcess&) = delete;
  ChildProcess& operator=(const ChildProcess&) = delete;

  [[nodiscard]] pid_t pid() const { return pid_; }
  /// How it ended, as waitpid says it. Waits; the same again afterwards.
  int wait();
  /// The same without waiting; nothing while it runs.
  std::optional<int> ended();
  void kill();

 private:
  pid_t pid_ = -1;
  std::optional<int> status_;
};

/// Where a program of ours lies: what the environment variable `named` names, else beside the running program. Throws
/// Error (work) when it is not there; `purpose`: "it reads pictures", for that.
[[nodiscard]] std::filesystem::path programBeside(const char* name, const char* named, const char* purpose);

}  // namespace argil::io
