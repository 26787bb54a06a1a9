#pragma once
// A device of a plugin's library: its process is the other end of the cable.

#include <memory>

#include "engine/plugins/plugin.h"
#include "haptics/devices/device_thread.h"
#include "plugins/runner/channel.h"

namespace argil::engine {

/// A device that is not there yet is used as soon as it is; what goes wrong with its process is in its status(). The
/// nodes that it may open are those that match when its process starts. Throws nothing that a plugin does.
[[nodiscard]] std::unique_ptr<haptics::Device> openPluginDevice(const Plugin::Device& device,
                                                                const PluginLibrary& library);

/// What a plugin says, as the servo takes it; false for what is not finite or farther away than twice the workspace.
[[nodiscard]] bool checkedState(const argil_device_state& said, const haptics::DeviceSheet& sheet,
                                haptics::DeviceState& state) noexcept;

}  // namespace argil::engine
