#include "engine/plugins/felt_guides.h"

#include <fmt/format.h>

#include "clay/base/error.h"

namespace argil::engine {

std::shared_ptr<PluginGuide> FeltGuide::begin(std::span<const float> values) const {
  std::vector<std::string> names;
  for (const AddedTool::Number& number : numbers) names.push_back(number.id);
  return std::make_shared<PluginGuide>(processes, id, names, values);
}

std::shared_ptr<PluginGuide> FeltGuide::begin() const {
  std::vector<float> values;
  for (const AddedTool::Number& number : numbers) values.push_back(static_cast<float>(number.standard));
  return begin(values);
}

void FeltGuides::add(FeltGuide guide) {
  const std::lock_guard lock(mutex_);
  for (const FeltGuide& each : guides_) {
    if (each.id != guide.id) continue;
    if (each.origin.checksum == guide.origin.checksum) return;
    throw Error(fmt::format("there is another guide with the id \"{}\"", guide.id));
  }
  guides_.push_back(std::move(guide));
}

std::vector<const FeltGuide*> FeltGuides::all() {
  const std::lock_guard lock(mutex_);
  std::vector<const FeltGuide*> all;
  for (const FeltGuide& each : guides_) all.push_back(&each);
  return all;
}

const FeltGuide* FeltGuides::find(std::string_view id) {
  const std::lock_guard lock(mutex_);
  for (const FeltGuide& each : guides_)
    if (each.id == id) return &each;
  return nullptr;
}

FeltGuides& feltGuides() {
  static FeltGuides guides;
  return guides;
}

}  // namespace argil::engine
