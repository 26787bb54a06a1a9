#pragma once
// A brush of a plugin's library.

#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "clay/brush/external_brush.h"
#include "engine/plugins/plugin_process.h"

namespace argil::engine {

/// The processes of one plugin's library: one for each stroke that is in work at the same time, kept for the next. Any
/// thread.
class PluginProcesses {
 public:
  explicit PluginProcesses(PluginLibrary library, const PluginLimits& limits = {});

  [[nodiscard]] const PluginLibrary& library() const { return library_; }
  /// One that waits, or a new one. Throws PluginError; Error once kMostFaults of them ended by a fault.
  [[nodiscard]] std::unique_ptr<PluginProcess> take(int threads);
  /// After its use. One that is dead counts as a fault.
  void giveBack(std::unique_ptr<PluginProcess> process);
  /// How often a process was started.
  [[nodiscard]] uint64_t started() const;
  /// Of the process that was started last; 0: none was.
  [[nodiscard]] pid_t newest() const;

  static constexpr int kMostFaults = 3;

 private:
  PluginLibrary library_;
  PluginLimits limits_;
  mutable std::mutex mutex_;
  std::vector<std::unique_ptr<PluginProcess>> waiting_;
  uint64_t started_ = 0;
  pid_t newest_ = 0;
  int faults_ = 0;
};

/// What plugin.json says of a brush of a library.
struct PluginBrushFacts {
  std::string id;
  int margin = 1;
  clay::Renew leaves = clay::Renew::all;
  std::vector<std::string> numbers;
};

class PluginBrush : public clay::ExternalBrush {
 public:
  PluginBrush(PluginBrushFacts facts, std::shared_ptr<PluginProcesses> processes);

  [[nodiscard]] int margin() const override { return facts_.margin; }
  [[nodiscard]] clay::Renew leaves() const override { return facts_.leaves; }
  [[nodiscard]] std::unique_ptr<clay::BrickWorker> begin(const clay::WorkerStroke& stroke) const override;

  [[nodiscard]] const PluginLibrary& library() const { return processes_->library(); }
  [[nodiscard]] PluginProcesses& processes() const { return *processes_; }

 private:
  PluginBrushFacts facts_;
  std::shared_ptr<PluginProcesses> processes_;
};

/// SHA-256 of a file, in hexadecimal digits; empty where it cannot be read.
[[nodiscard]] std::string fileChecksum(const std::filesystem::path& file);

/// The same of the numbers of the thing that was described last.
void requireNumbers(PluginProcess& process, const std::string& thing, const std::vector<std::string>& numbers);
/// Throws PluginError (notAsSaid) where the library says of the brush what plugin.json does not.
void requireAsSaid(PluginProcess& process, const PluginBrushFacts& facts);

}  // namespace argil::engine
