#pragma once
// The numbers that every pass of one picture shares. Plain floats: no Vulkan here.

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "render/renderer/renderer.h"
#include "render/view/quality.h"

namespace argil::render {

/// Mirrors the block of shaders/frame.glsl, which says what each member holds.
struct FrameUniforms {
  using Vec4 = std::array<float, 4>;
  struct Eye {
    Vec4 right, up, forward, place;
  };
  Vec4 cameraRight, cameraUp, cameraForward;
  std::array<Eye, 2> eyes;
  Vec4 scale, depth, size;
  Vec4 keyLight, shadowX, shadowY, shadowZ;
  Vec4 ground, gridU, gridV, gridFade;
  Vec4 ball, shaft, shaftRadii, drop, marker;
  Vec4 tint, section, fade;
  Vec4 backTop, backBottom, groundColour, minorLine, majorLine;
  std::array<Vec4, kMostPlaneMarks> planes, planeLines, planeTints, planeSizes;
};
static_assert(sizeof(FrameUniforms) == 51 * 16);

/// A segment as shaders/line.vert reads it.
struct LineInstance {
  float a[3], widthSamples;
  float b[3], ends = 0;  ///< 1: flat at a, 2: at b, 3: both, else round; 4 more: does not fade with depth.
  float colour[4];       ///< Display-linear, alpha.
};
static_assert(sizeof(LineInstance) == 48);

/// A corner as shaders/fill.vert reads it.
struct FillVertex {
  float rel[3];
  float colour[4];  ///< Display-linear, alpha.
};
static_assert(sizeof(FillVertex) == 28);

/// All that is known of a picture before the device is asked: pure, so that tests can look at it.
struct FramePlan {
  FrameUniforms uniforms{};
  Look look;  ///< As asked for, less what the quality leaves out or what there is nothing to see of.
  StereoMode stereo = StereoMode::mono;
  bool perspective = true;
  bool cursor = false;  ///< There is one.
  /// Facing: lines in the picture's plane. Level: seen from above, so never before clay. Below: that seen from below.
  enum class Ground : uint8_t { none, level, facing, below } ground = Ground::none;
  /// Samples that hold the mark where the beam lands, for all eyes; empty without one.
  struct Rectangle {
    int left = 0, top = 0, right = 0, bottom = 0;
    [[nodiscard]] bool empty() const { return left >= right || top >= bottom; }
  } landing;
  [[nodiscard]] int eyes() const { return Stereo{stereo}.both() ? 2 : 1; }

  std::array<std::vector<LineInstance>, 3> worldLines;  ///< Relative to the eye, by Depth.
  std::vector<LineInstance> screenLines;                ///< In samples from the top left corner.
  std::vector<FillVertex> fillVertices;                 ///< Relative to the eye, three a triangle.
  struct FillRun {
    Depth depth;
    uint32_t first, count;
  };
  std::vector<FillRun> fills;  ///< Of vertices, in the order to draw.

  Vec3d eye = Vec3d::Zero();  ///< Between both eyes; what "relative to the eye" means.
  /// The sides of what is seen, by both eyes together: a point p in world mm is outside where normal · (p − eye) >
  /// offset.
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

[[nodiscard]] FramePlan planFrame(const Shot& shot, const Subject& subject, const Quality& quality, int width,
                                  int height);

}  // namespace argil::render
