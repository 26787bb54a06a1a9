#pragma once
// What each destination of a model wants, in one table.

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string_view>

#include "engine/models/model_files.h"

namespace argil::engine {

struct ExportPreset {
  std::string_view id;                        ///< On the command line.
  std::string_view name;                      ///< In the studio.
  std::string_view help;                      ///< One sentence for the user.
  std::span<const std::string_view> endings;  ///< Of the files, each with its dot; the first where one is enough.
  std::optional<uint64_t> triangles = {};     ///< As ModelExport has these.
  bool recentre = false;
  bool draco = false;
  std::optional<size_t> quads = {};
  int texturePixels = 0;
};

[[nodiscard]] std::span<const ExportPreset> exportPresets();
/// Throws Error that lists those there are.
[[nodiscard]] const ExportPreset& exportPresetNamed(std::string_view id);
/// What the preset says, where `what` has not been told otherwise. Throws Error when the destination wants other files.
void applyPreset(const ExportPreset& preset, const std::filesystem::path& file, ModelExport& what);

}  // namespace argil::engine
