#pragma once
// Two eyes.

#include <cstdint>
#include <optional>
#include <span>
#include <string_view>

namespace argil::render {

enum class StereoMode : uint8_t {
  mono,
  anaglyph,    ///< Red for the left eye, cyan for the right; colours mixed after Dubois so that the eyes do not fight.
  sideBySide,  ///< Left half, right half: each eye's picture squeezed to half of the width.
  topBottom,   ///< Upper half left eye, lower half right eye: squeezed to half of the height.
  leftEye,     ///< One eye alone, full size: for pairs of images.
  rightEye,
};

/// Both eyes look along parallel axes; their pictures are shifted so that the plane at `convergence` has no parallax
/// (off-axis frusta: no keystone). A point at distance z along the view appears in the right eye's picture to the right
/// of its place in the left eye's by  eyeDistance · (1/convergence − 1/z) · (width in pixels per unit of x/z)  pixels:
/// negative, so to the left, when it is nearer than the convergence. Orthographic views have no depth: there each eye
/// turns by atan(eyeDistancePart / 2) about the point of the view's axis at the convergence, and the same point has a
/// parallax of  2 · sin(angle) · (z − convergence)  mm. Lines on the screen (scale bar, labels) have no parallax.
struct Stereo {
  StereoMode mode = StereoMode::mono;
  double eyeDistancePart = 0.035;  ///< Between the eyes, as a part of the distance to the target: 0 to 0.2.
  double convergencePart = 1;      ///< Distance without parallax, as a part of the distance to the target: 0.2 to 5.
  bool swapEyes = false;           ///< Exchanges the two pictures of the modes that show both.

  /// Each eye has a half of the picture.
  [[nodiscard]] bool splits() const { return mode == StereoMode::sideBySide || mode == StereoMode::topBottom; }
  /// Both eyes are in the picture.
  [[nodiscard]] bool both() const {
    return mode == StereoMode::anaglyph || mode == StereoMode::sideBySide || mode == StereoMode::topBottom;
  }
};

/// Names for people and files: "mono", "anaglyph", "side-by-side", "top-bottom", "left-eye", "right-eye", in the order
/// of the modes.
[[nodiscard]] std::span<const std::string_view> stereoModeNames();
[[nodiscard]] std::optional<StereoMode> stereoModeNamed(std::string_view name);

/// Throws Error (input) that names the member that is out of range.
void check(const Stereo& stereo);

}  // namespace argil::render
