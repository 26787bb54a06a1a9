#pragma once
// What smooth solids for CAD are written from.

#include <array>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "clay/cage/patch_net.h"

namespace argil::io {

/// A closed surface.
struct CadBody {
  std::string name;
  const clay::PatchSurface* surface = nullptr;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  std::optional<std::array<float, 3>> colour = {};  ///< sRGB.
};

/// Whether a file's ending says STEP, or IGES.
[[nodiscard]] bool isStep(const std::filesystem::path& file);
[[nodiscard]] bool isIges(const std::filesystem::path& file);
[[nodiscard]] inline bool isCad(const std::filesystem::path& file) {
  return isStep(file) || isIges(file);
}

/// Quads that bound one piece of matter.
struct CadSolid {
  std::vector<uint32_t> outer;
  std::vector<std::vector<uint32_t>> cavities;
};
/// A solid for each body of a surface. A cavity belongs to the smallest body around it.
[[nodiscard]] std::vector<CadSolid> solidsOf(const clay::PatchSurface& surface, const clay::QuadTopology& topology);

/// Appends a real number as both formats have it: the very double, with a point. Throws Error for one that is not
/// finite.
void appendReal(std::string& out, double value);

}  // namespace argil::io
