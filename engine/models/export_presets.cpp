#include "engine/models/export_presets.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <string>

#include "clay/base/error.h"
#include "io/bytes/input.h"

namespace argil::engine {

namespace {

using Endings = std::array<std::string_view, 1>;
constexpr Endings kThreeMf{".3mf"}, kGlb{".glb"};
constexpr std::array<std::string_view, 2> kStep{".step", ".stp"};
constexpr std::array<std::string_view, 2> kArchive{".vdb", ".3mf"};

constexpr std::array kPresets{
    ExportPreset{"slicer", "Slicer", "3MF: millimetres, names and colours, one object a piece, every triangle.",
                 kThreeMf},
    ExportPreset{"blender", "Blender", "glTF that every Blender opens: names, colours, matt, where it is.", kGlb},
    ExportPreset{"game", "Game", "glTF of 100 000 triangles at most, its middle at zero, that every engine opens.",
                 kGlb, 100'000, true},
    ExportPreset{"web", "Web", "glTF of 200 000 triangles at most, packed with Draco: small to send.", kGlb, 200'000,
                 true, true},
    ExportPreset{"textured",
                 "Quads",
                 "glTF of 4 000 quads a piece at most, with the clay's normals and colours as pictures.",
                 kGlb,
                 {},
                 false,
                 false,
                 4000,
                 2048},
    ExportPreset{"cad", "CAD", "STEP: a smooth solid for each piece, and how far it lies off the clay.", kStep},
    ExportPreset{"archive", "Archive",
                 "The clay itself as a level set and its surface as 3MF: open formats, all of it.", kArchive},
};

}  // namespace

std::span<const ExportPreset> exportPresets() {
  return kPresets;
}

const ExportPreset& exportPresetNamed(std::string_view id) {
  const auto row =
      std::find_if(kPresets.begin(), kPresets.end(), [&](const ExportPreset& each) { return each.id == id; });
  if (row != kPresets.end()) return *row;
  std::string names;
  for (const ExportPreset& each : kPresets) names += (names.empty() ? "" : ", ") + std::string(each.id);
  throw Error(fmt::format("--for {}: give one of {}", id, names));
}

void applyPreset(const ExportPreset& preset, const std::filesystem::path& file, ModelExport& what) {
  const std::string ending = io::endingOf(file);
  if (std::find(preset.endings.begin(), preset.endings.end(), ending) == preset.endings.end())
    throw Error(fmt::format("{}: --for {} writes {}; name the file so", file.string(), preset.id,
                            fmt::join(preset.endings, " and ")));
  if (!what.triangles && !what.errorMm) what.triangles = preset.triangles;
  what.recentre = what.recentre || (preset.recentre && !what.putBack);
  what.draco = what.draco || preset.draco;
  if (preset.quads && !what.quads) {
    what.quads = preset.quads;
    what.texturePixels = preset.texturePixels;
  }
}

}  // namespace argil::engine
