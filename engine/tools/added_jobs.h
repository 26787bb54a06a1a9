#pragma once
// Operations on whole pieces that plugins brought.

#include <atomic>
#include <functional>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <vector>

#include "engine/tools/added_tools.h"
#include "engine/tools/piece_jobs.h"

namespace argil::engine {

/// An operation on one piece.
struct AddedJob {
  ToolOrigin origin;
  std::string id, name, help, doing;
  std::vector<AddedTool::Number> numbers;  ///< 8 at most.
  /// The piece's clay, as it becomes. Throws Error, Cancelled. Any thread.
  std::function<clay::Version(const clay::Version& version, std::span<const float> values, Job* job)> run;
};

/// All operations: the program's and those that were added, which stay for the life of the program. Any thread.
class AddedJobs {
 public:
  AddedJobs();
  [[nodiscard]] std::span<const PieceJob> all() const { return {rows_.get(), count_.load(std::memory_order_acquire)}; }
  /// Throws Error: an id that another operation has, numbers that no program could use, too many. What was added by the
  /// same plugin before is left as it is.
  void add(const AddedJob& job);

  static constexpr size_t kMost = 200;  ///< With the program's.

 private:
  struct Kept;
  std::mutex mutex_;
  std::unique_ptr<PieceJob[]> rows_;
  std::atomic<size_t> count_;
  std::vector<std::unique_ptr<const Kept>> kept_;
};
[[nodiscard]] AddedJobs& addedJobs();

[[nodiscard]] PieceResult runAdded(const AddedJob& added, const Document& document, const PieceArguments& arguments,
                                   Job* job);

}  // namespace argil::engine
