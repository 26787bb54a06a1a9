#pragma once
// Guides that plugins brought, to be felt wherever the hand works.

#include <deque>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "engine/plugins/plugin_guide.h"
#include "engine/tools/added_tools.h"

namespace argil::engine {

struct FeltGuide {
  ToolOrigin origin;
  std::string id, name, help;
  std::vector<AddedTool::Number> numbers;
  std::shared_ptr<PluginProcesses> processes;

  /// Begins it with these values. Throws PluginError.
  [[nodiscard]] std::shared_ptr<PluginGuide> begin(std::span<const float> values) const;
  /// With its numbers as they begin.
  [[nodiscard]] std::shared_ptr<PluginGuide> begin() const;
};

/// Those of enabled plugins; what was added stays for the life of the program. Any thread.
class FeltGuides {
 public:
  /// Throws Error: another plugin has a guide of that id.
  void add(FeltGuide guide);
  [[nodiscard]] std::vector<const FeltGuide*> all();
  /// Null: there is none.
  [[nodiscard]] const FeltGuide* find(std::string_view id);

 private:
  std::mutex mutex_;
  std::deque<FeltGuide> guides_;
};
[[nodiscard]] FeltGuides& feltGuides();

}  // namespace argil::engine
