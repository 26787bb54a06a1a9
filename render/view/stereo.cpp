#include "render/view/stereo.h"

#include <algorithm>
#include <array>

#include "clay/base/error.h"

namespace argil::render {
namespace {

constexpr std::array<std::string_view, 6> kStereoModes{"mono",       "anaglyph", "side-by-side",
                                                       "top-bottom", "left-eye", "right-eye"};

bool within(double value, double least, double most) {
  return value >= least && value <= most;  // false for NaN
}

}  // namespace

std::span<const std::string_view> stereoModeNames() {
  return kStereoModes;
}

std::optional<StereoMode> stereoModeNamed(std::string_view name) {
  const auto found = std::find(kStereoModes.begin(), kStereoModes.end(), name);
  if (found == kStereoModes.end()) return std::nullopt;
  return static_cast<StereoMode>(found - kStereoModes.begin());
}

void check(const Stereo& stereo) {
  if (!within(stereo.eyeDistancePart, 0, 0.2))
    throw Error("the distance between the eyes must lie between 0 and 0.2 of the distance to the target");
  if (!within(stereo.convergencePart, 0.2, 5))
    throw Error("the convergence must lie between 0.2 and 5 times the distance to the target");
}

}  // namespace argil::render
