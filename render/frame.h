#pragma once
// The numbers that every pass of one picture shares. Plain floats: no Vulkan here.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "render/overlays.h"
#include "render/quality.h"
#include "render/view.h"

namespace argil::render {

/// Mirrors the block of shaders/frame.glsl, which says what each member holds.
struct FrameUniforms {
  using Vec4 = std::array<float, 4>;
  Vec4 cameraRight, cameraUp, cameraForward;
  Vec4 scale, depth, size;
  Vec4 keyLight, shadowX, shadowY, shadowZ;
  Vec4 ground, gridU, gridV, gridFade;
  Vec4 ball, shaft, shaftRadii, drop, marker;
};
static_assert(sizeof(FrameUniforms) == 19 * 16);

/// A segment as shaders/line.vert reads it.
struct LineInstance {
  float a[3], widthSamples;
  float b[3], unused = 0;
  float colour[4];  ///< Display-linear, alpha.
};
static_assert(sizeof(LineInstance) == 48);

/// All that is known of a picture before the device is asked: pure, so that tests can look at it.
struct FramePlan {
  FrameUniforms uniforms{};
  std::vector<LineInstance> worldLines;   ///< Relative to the eye, depth-tested.
  std::vector<LineInstance> screenLines;  ///< In samples from the top left corner.
  Vec3d eye = Vec3d::Zero();
  /// The six sides of what is seen: a point p in world mm is outside where normal · (p − eye) > offset.
  struct Side {
    Vec3d normal;
    double offset;
  };
  std::vector<Side> sides;
};

/// What the clay is to a picture.
struct Subject {
  Box bounds;  ///< Empty without clay.
  std::optional<double>
      beamLengthMm;  ///< From the cursor's centre along its drop to clay or ground, where it meets them.
};

/// z of the ground: the lowest point of the clay, 0 without clay.
[[nodiscard]] double groundHeight(const Box& bounds);

[[nodiscard]] FramePlan planFrame(const View& view, const Overlays& overlays, const Subject& subject,
                                  const Quality& quality, int width, int height);

}  // namespace argil::render
