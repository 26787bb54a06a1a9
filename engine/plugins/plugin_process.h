#pragma once
// A plugin's library at work, in a process of its own.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "clay/base/error.h"
#include "clay/base/job.h"
#include "io/bytes/child_process.h"
#include "plugins/runner/channel.h"

namespace argil::engine {

/// What went wrong with a plugin at work.
enum class PluginFault : uint8_t {
  notThere,    ///< Its library, or argil-plugin, cannot be found or started.
  cannotLoad,  ///< The library cannot be loaded: another machine's, a symbol that is missing.
  noEntry,     ///< It is no plugin of this version.
  notAsSaid,   ///< It is or has something else than plugin.json says.
  crashed,     ///< Its process ended.
  hung,        ///< It did not answer in time.
  memory,      ///< It needs more memory than it may have.
  outside,     ///< It wrote where it may not: looked for where PluginLimits says so.
  notFinite,   ///< It gave a number that is not finite.
  failed,      ///< It said itself that it failed.
};
[[nodiscard]] std::string_view nameOf(PluginFault fault);

class PluginError : public Error {
 public:
  PluginError(PluginFault fault, const std::string& sentence) : Error(sentence, Kind::work), fault_(fault) {}
  [[nodiscard]] PluginFault fault() const { return fault_; }

 private:
  PluginFault fault_;
};

/// The library of a plugin, as its process is started.
struct PluginLibrary {
  std::string id, name, version, checksum;  ///< Of the plugin.
  std::filesystem::path folder, file;
  std::vector<std::string> nodes = {};  ///< In /dev, that this process may open.
};

struct PluginLimits {
  double startS = 5;      ///< Of processor time until it is ready.
  double callS = 0.25;    ///< Of processor time for a stamp, and each of its threads.
  double silentS = 0.25;  ///< Without an answer while none of its threads computes.
  double workS = 5;       ///< The same while it works on a file or on a whole piece.
  uint64_t memoryBytes = uint64_t{2} << 30;
  bool comparesWindow = false;  ///< Whether it changes what it was given, or what is not its own: slow, for trials.
};

/// argil-plugin with a library loaded. One thread at a time.
class PluginProcess {
 public:
  /// Returns when the library is ready. Throws PluginError.
  PluginProcess(const PluginLibrary& library, int threads, const PluginLimits& limits = {});

  [[nodiscard]] const PluginLibrary& library() const { return library_; }
  [[nodiscard]] const PluginLimits& limits() const { return limits_; }
  /// What is written there reaches the process with the next call(); what it answers lies there. Nothing in it may be
  /// believed, and it may change at any time.
  [[nodiscard]] plugin::Channel& channel() const { return *static_cast<plugin::Channel*>(memory_.get()); }
  [[nodiscard]] std::byte* window() const { return static_cast<std::byte*>(memory_.get()) + plugin::kWindowAt; }

  /// What the next commands are about.
  void name(plugin::ThingKind kind, const std::string& thing);
  /// Has a command done. Throws PluginError when it says that it failed; when it crashed or hung, the process is gone
  /// then and every other call throws the same.
  void call(plugin::Command command) {
    begin(command);
    finish();
  }
  /// The same in two: what it reads may come in between, as far as the command says so.
  void begin(plugin::Command command);
  void finish();
  /// The same for work that takes as long as it takes and asks for things meanwhile: `serve` answers each, and gives
  /// what Channel::result is to be; its progress is that share of the job's. What `serve` throws comes out once the
  /// process has been told to stop. Throws Cancelled; a process that does not stop within 100 ms is killed.
  void run(plugin::Command command, const std::function<uint64_t(plugin::Upcall)>& serve, Job* job, double share = 1);
  /// The process is killed; `fault` is what every other call throws. Throws it itself.
  [[noreturn]] void end(PluginFault fault, const std::string& what);

  [[nodiscard]] bool alive();
  [[nodiscard]] pid_t pid() const { return process_->pid(); }
  /// The first system call that it was refused, in words; empty: none was.
  [[nodiscard]] std::string refusedCall() const;
  /// What it cannot be kept from on this system; empty: nothing.
  [[nodiscard]] std::string unconfined() const;
  /// Its last sentence: one line.
  [[nodiscard]] std::string sentence() const;

  /// One line of a text in a channel.
  [[nodiscard]] static std::string textOf(const char (&text)[plugin::kMostText]);

 private:
  struct Unmap {
    void operator()(void* memory) const;
  };
  void ask();
  uint32_t before_ = 0;  // answers, when the last command began
  void waitFor(uint32_t before, double seconds, double silentS, Job* job = nullptr, double share = 1);
  void stop(uint32_t before);
  void requireDone();
  [[noreturn]] void failEnd(int status);

  PluginLibrary library_;
  PluginLimits limits_;
  int threads_;
  std::unique_ptr<void, Unmap> memory_;
  struct Fd {
    Fd() = default;
    ~Fd();
    Fd(const Fd&) = delete;
    Fd& operator=(const Fd&) = delete;
    int fd = -1;
  };
  Fd life_;  // its other end tells the process that we are there
  std::unique_ptr<io::ChildProcess> process_;
  std::unique_ptr<PluginError> ended_;
};

/// Where argil-plugin is: what ARGIL_PLUGIN names, else beside the running program. Throws Error when it is not there.
[[nodiscard]] std::filesystem::path pluginProgram();

}  // namespace argil::engine
