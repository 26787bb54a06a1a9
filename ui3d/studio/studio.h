#pragma once
// The studio: a window, the clay in it, and a person's hands on it.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "ui3d/studio/view/studio_state.h"

namespace argil::studio {

struct StudioOptions {
  std::filesystem::path file;  ///< To open; empty: the first-start page.
  int width = 0, height = 0;   ///< Pixels of the window; 0: most of the screen.
  float scale = 0;             ///< Pixels an interface unit; 0: as the display says.
  /// A recording in place of a person: the studio ends with it. Settings are the standard ones then.
  std::filesystem::path play;
  double playSpeed = 1;            ///< So many times as fast, 0.1 to 100.
  std::filesystem::path record;    ///< Events are written there as they come.
  std::filesystem::path report;    ///< Figures as JSON at the end.
  std::string device = "pointer";  ///< Stylus, by the names of `argil devices`.
  std::optional<Theme> theme;
  bool validate = false;              ///< With Vulkan's validation layer.
  std::function<bool()> interrupted;  ///< Ctrl-C on the terminal: leaves without asking.
  std::string notice;                 ///< A warning to begin with; empty: none.
  std::function<void()> settled;      ///< Called once it has run for 10 s; may be null.
};

/// Runs until the person leaves. On the process' first thread. Throws Error: input for a file or a recording that
/// cannot be read, work for no display, no driver, or a check of a recording that did not come true in
/// Player::kCheckSeconds.
void runStudio(const StudioOptions& options);

}  // namespace argil::studio
