#pragma once
// What the hand holds.

#include <array>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "clay/brush/brush.h"
#include "engine/document/quality.h"

namespace argil::engine {

/// Radius of a tool in voxels of the clay that it is used on.
inline constexpr double kLeastToolVoxels = 0.5, kMostToolVoxels = 4096;

/// Numbers that a tool of a plugin may have beside those that all have.
inline constexpr size_t kMostOwnNumbers = 8;

/// What a pressure of 0 to 1 counts as; `curve`: −1: a light touch does much already, 0: as it is, 1: it does little.
[[nodiscard]] double curvedPressure(double curve, double pressure);

/// What was read from a tool's file: follows from its name, so it is neither compared nor saved.
struct ToolFileContent {
  std::shared_ptr<const clay::HeightImage> image;
  std::shared_ptr<const clay::StampShape> shape;
  friend bool operator==(const ToolFileContent&, const ToolFileContent&) { return true; }
};

/// A tool as a user has set it; the same for a whole stroke. What of it counts, and in which range, its row says
/// (engine/tools/tool_table.h).
struct Tool {
  std::string_view id = "carve";  ///< Of its row; a view of the table's own text.
  double radiusMm = 5;            ///< kLeastToolVoxels to kMostToolVoxels.
  double strength = 1;            ///< 0 to 1.
  bool inverted = false;          ///< The other way round, where the row has one.
  double heightMm = 1, blendMm = 1, angleDeg = 45;
  double depth = 0.15;     ///< Of the radius: how far a pass of clay or of a soft carve goes. 0.01 to 1.
  bool soft = false;       ///< Carve: takes a layer off along the normals in place of cutting the tip out.
  double evenOut = 1;      ///< Smooth: how many times the usual width of bumps squared it evens out. 1 to 64.
  double leastWallMm = 0;  ///< No wall is cut thinner than this; 0: no limit.
  clay::Falloff falloff = clay::Falloff::smooth;
  clay::Tip tip = clay::Tip::ball;
  double breadth = 1, thickness = 1;  ///< Of the tip's y and z beside its x: 0.05 to 1.
  double round = 0.2;
  uint32_t colour = 0xc8402e;  ///< 0xRRGGBB.
  int material = 1;
  double stabiliseMm = 0;  ///< Length of the string on which the tool is drawn; the force path does not know of it.
  double radiusByPressure = 0, strengthByPressure = 0;  ///< Share that the pressure rules: 0 to 1.
  double pressureCurve = 0;                             ///< −1: early, 0: straight, 1: late.
  bool pressureIsForce = false;                         ///< The felt force is the pressure, fullForceN of it being 1.
  double fullForceN = 3;
  std::array<double, kMostOwnNumbers> own{};  ///< Of a tool that came by a plugin, in its row's units.
  StrokeQuality quality = {};                 ///< Of the document or the script that it is used in.
  int morphTo = 0;                            ///< Goes back to the clay after so many steps.
  std::string file = {};                      ///< Of the image or the shape that it works with.
  ToolFileContent content = {};               ///< What was read from it.

  friend bool operator==(const Tool& a, const Tool& b) = default;
};

}  // namespace argil::engine
