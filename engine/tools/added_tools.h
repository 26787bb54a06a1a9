#pragma once
// Tools that plugins brought.

#include <atomic>
#include <functional>
#include <map>
#include <memory>
#include <mutex>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine/tools/tool_table.h"

namespace argil::engine {

/// A tool that is no row of the program's: a formula (clay/brush/formula.h), or a brush that is computed elsewhere.
struct AddedTool {
  /// A number that its formula reads by its id; ids are no word of a formula.
  struct Number {
    std::string id, name, help;
    std::string unit;  ///< "mm", "share", "°" or empty: as the formula gets it.
    double low = 0, high = 1, standard = 0;
    bool logarithmic = false;
  };
  /// The plugin that it came by; nothing where a script brought it along.
  ToolOrigin origin;
  std::string id, name, help;
  /// A drawing in a square of 24, as ui3d/studio/kit/icons.cpp reads it; empty: the name's letters stand for it.
  std::string icon = {};
  std::string formula;                                  ///< Empty: `external` does the work.
  std::shared_ptr<const clay::ExternalBrush> external;  ///< Null: `formula` does, or `image`.
  /// Not empty: it presses this image into the surface, as the emboss tool does its own, with its numbers' values.
  /// Throws Error.
  std::function<std::shared_ptr<const clay::HeightImage>(std::span<const float> values)> image = {};
  std::vector<Number> numbers;  ///< kMostOwnNumbers at most.
  clay::Falloff falloff = clay::Falloff::smooth;
  double strength = 1;
  bool inverts = false;  ///< The invert key makes it do the opposite.
  bool adds = false;     ///< clay::Brush::adds.
};

/// Throws Error for numbers that no program could use; `of` names whose they are.
void checkNumbers(const std::vector<AddedTool::Number>& numbers, std::string_view of);
/// Throws Error for what no program could use: texts, numbers, a formula that cannot be read.
void checkTool(const AddedTool& tool);

/// All tools: the program's and those that were added, which stay for the life of the program, as tools in hand, steps
/// and recordings name them. Any thread.
class AddedTools {
 public:
  AddedTools();
  [[nodiscard]] std::span<const ToolRow> all() const { return {rows_.get(), count_.load(std::memory_order_acquire)}; }
  /// Throws Error: a formula that cannot be read, an id that another tool has, numbers out of order, too many tools.
  /// What was added word for word before is given back, of a library if it is the same one.
  const ToolRow& add(const AddedTool& tool);
  /// The same of what a script or a journal brings along, whose id another tool may have: then it gets a number behind
  /// it. The plugin does not matter.
  const ToolRow& addBeside(AddedTool tool);
  /// Whether a stroke can be done again by what a script says of it: without the plugin.
  [[nodiscard]] static bool repeats(const AddedTool& tool) { return !tool.external && !tool.image; }
  /// What was added as this row; null: it is the program's.
  [[nodiscard]] const AddedTool* addedAs(const ToolRow& row);
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
