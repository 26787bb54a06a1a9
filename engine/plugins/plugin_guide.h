#pragma once
// A felt guide of a plugin's library: the servo reads what its process says.

#include <memory>
#include <string>
#include <vector>

#include "engine/plugins/plugin_brush.h"
#include "haptics/scene/local_model.h"

namespace argil::engine {

/// At work as long as it lives. newest() and tell() are the servo's; the others are of one thread.
class PluginGuide : public haptics::LocalModelSource {
 public:
  /// Throws PluginError.
  PluginGuide(std::shared_ptr<PluginProcesses> processes, const std::string& guide,
              const std::vector<std::string>& numbers, std::span<const float> values);
  ~PluginGuide() override;

  [[nodiscard]] bool newest(haptics::LocalModel& model) ARGIL_REALTIME override;
  void tell(const Vec3d& hand, const Vec3d& velocity, uint32_t buttons) ARGIL_REALTIME override;

  /// The newest, as it was said and not looked at; false: there is none since. In place of newest().
  [[nodiscard]] bool said(argil_local_model& model) ARGIL_REALTIME;
  /// Throws PluginError once its process has ended: what it said last fades by itself.
  void look();

 private:
  std::shared_ptr<PluginProcesses> processes_;
  std::unique_ptr<PluginProcess> process_;
  plugin::Channel* channel_;
  uint64_t seen_ = 0;
};

/// What a plugin says, as the servo takes it; false for what is not finite or out of range. Real-time safe.
[[nodiscard]] bool checkedModel(const argil_local_model& said, haptics::LocalModel& model) ARGIL_REALTIME;

}  // namespace argil::engine
