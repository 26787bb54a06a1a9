#pragma once
// Two eyes.

#include <cstdint>

namespace argil::render {

enum class StereoMode : uint8_t {
  mono,
  anaglyph,    ///< Red for the left eye, cyan for the right, colours reduced so that the eyes do not fight.
  sideBySide,  ///< Left half, right half: each eye's picture squeezed to half of the width.
  topBottom,   ///< Upper half left eye, lower half right eye: squeezed to half of the height.
  leftEye,     ///< One eye alone, full size: for pairs of images.
  rightEye,
};

/// Both eyes look along parallel axes; their pictures are shifted so that the plane at `convergence` has no parallax
/// (off-axis frusta: no keystone). A point at distance z along the view appears in the right eye's picture left of its place in the left
/// eye's by  eyeDistance · (1/convergence − 1/z) · (width in pixels per unit of x/z)  pixels, negative when it is nearer.
/// Orthographic views have no depth: there the eyes turn by the same angle about the target instead.
struct Stereo {
  StereoMode mode = StereoMode::mono;
  double eyeDistancePart = 0.035;  ///< Between the eyes, as a part of the distance to the target: 0 to 0.2.
  double convergencePart = 1;      ///< Distance without parallax, as a part of the distance to the target: 0.2 to 5.
  bool swapEyes = false;
};

}  // namespace argil::render
