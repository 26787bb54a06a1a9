#pragma once
// What the studio keeps from one day to the next.

#include <filesystem>
#include <string>

#include "ui3d/studio/view/studio_state.h"

namespace argil::studio {

/// $XDG_CONFIG_HOME/argil/studio.json, else ~/.config/argil/studio.json; empty when there is no home.
[[nodiscard]] std::filesystem::path settingsFile();

/// Theme, scale, shortcuts, recent files, panels, tools, looks, quality.
[[nodiscard]] std::string settingsText(const StudioState& state);
/// Takes over what the text holds. What is missing, unknown or out of range leaves the state as it is; false when it is
/// no JSON object.
bool applySettings(const std::string& text, StudioState& state);

/// Nothing happens when there is no file.
void loadSettings(StudioState& state);
/// By way of a temporary file. A folder that cannot be written is no reason to stop: false.
bool saveSettings(const StudioState& state);

}  // namespace argil::studio
