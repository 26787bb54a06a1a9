#pragma once
// Tools that plugins brought.

#include <atomic>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/tools/tool_table.h"

namespace argil::engine {

/// A tool whose work is a formula (clay/brush/formula.h).
struct FormulaTool {
  /// A number that its formula reads by its id; ids are no word of a formula.
  struct Number {
    std::string id, name, help;
    std::string unit;  ///< "mm", "share", "°" or empty: as the formula gets it.
    double low = 0, high = 1, standard = 0;
    bool logarithmic = false;
  };
  std::string plugin, id, name, help, formula;
  std::vector<Number> numbers;  ///< kMostOwnNumbers at most.
  clay::Falloff falloff = clay::Falloff::smooth;
  double strength = 1;
  bool inverts = false;  ///< The invert key makes it do the opposite.
};

/// Throws Error for what no program could use: texts, numbers, a formula that cannot be read.
void checkTool(const FormulaTool& tool);

/// All tools: the program's and those that were added, which stay for the life of the program, as tools in hand, steps
/// and recordings name them. Any thread.
class AddedTools {
 public:
  AddedTools();
  [[nodiscard]] std::span<const ToolRow> all() const { return {rows_.get(), count_.load(std::memory_order_acquire)}; }
  /// Throws Error: a formula that cannot be read, an id that another tool has, numbers out of order, too many tools.
  /// What was added word for word before is given back.
  const ToolRow& add(const FormulaTool& tool);
  /// The same of what a script or a journal brings along, whose id another tool may have: then it gets a number behind
  /// it. The plugin does not matter.
  const ToolRow& addBeside(FormulaTool tool);
  /// What was added as this row; null: it is no formula's.
  [[nodiscard]] const FormulaTool* formulaOf(const ToolRow& row);
  /// Why there is no such tool, in a sentence, for whoever asks for it.
  void explain(std::string_view id, std::string sentence);
  /// Empty: nothing is known of it.
  [[nodiscard]] std::string whyNot(std::string_view id);

  static constexpr size_t kMost = 1000;  ///< With the program's.

 private:
  struct Kept;
  std::mutex mutex_;
  std::unique_ptr<ToolRow[]> rows_;
  std::atomic<size_t> count_;
  std::vector<std::unique_ptr<const Kept>> kept_;
  std::map<std::string, std::string, std::less<>> why_;
};
[[nodiscard]] AddedTools& addedTools();

}  // namespace argil::engine
