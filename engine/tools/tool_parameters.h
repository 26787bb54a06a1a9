#pragma once
// What can be set of a tool, as rows with their units and ranges; each stands in the parameters of any number of tools
// (tool_table.cpp).

#include <array>
#include <string_view>

#include "engine/tools/tool_table.h"

namespace argil::engine::tool_parameters {

using Row = Parameter<Tool>;

inline constexpr std::array<std::string_view, 5> kFalloffs{"constant", "smooth", "linear", "sharp", "dome"};
inline constexpr std::array<std::string_view, 3> kTips{"ball", "ellipsoid", "box"};

inline constexpr Row kRadius{
    .id = "radius",
    .name = "Radius",
    .help = "Radius of the tip.",
    .unit = "mm",
    .low = 0.005,
    .high = 1000,
    .standard = 5,
    .logarithmic = true,
    .get = [](const Tool& t) { return t.radiusMm; },
    .set = [](Tool& t, double v) { t.radiusMm = v; },
};
inline constexpr Row kStrength{
    .id = "strength",
    .name = "Strength",
    .help = "How much of its work a pass does.",
    .unit = "share",
    .low = 0.01,
    .high = 1,
    .standard = 0.5,
    .get = [](const Tool& t) { return t.strength; },
    .set = [](Tool& t, double v) { t.strength = v; },
};
inline constexpr Row kHeight{
    .id = "height",
    .name = "Height",
    .help = "How high it lays clay, or how deep it cuts.",
    .unit = "mm",
    .low = 0.001,
    .high = 500,
    .standard = 1,
    .logarithmic = true,
    .get = [](const Tool& t) { return t.heightMm; },
    .set = [](Tool& t, double v) { t.heightMm = v; },
};
inline constexpr Row kDepth{
    .id = "depth",
    .name = "Depth",
    .help = "Depth of a soft cut, relative to the radius.",
    .unit = "share",
    .low = 0.01,
    .high = 1,
    .standard = 0.15,
    .get = [](const Tool& t) { return t.depth; },
    .set = [](Tool& t, double v) { t.depth = v; },
};
inline constexpr Row kBuildUp{
    .id = "depth",
    .name = "Build-up",
    .help = "Thickness of clay that a pass lays, relative to the radius.",
    .unit = "share",
    .low = 0.01,
    .high = 1,
    .standard = 0.15,
    .get = [](const Tool& t) { return t.depth; },
    .set = [](Tool& t, double v) { t.depth = v; },
};
inline constexpr Row kSoftCut{
    .id = "soft",
    .name = "Soft",
    .help = "Takes off a shallow layer with a smooth rim. Off: cuts the tip out of the clay, with a hard edge.",
    .unit = "on",
    .low = 0,
    .high = 1,
    .standard = 0,
    .get = [](const Tool& t) { return t.soft ? 1.0 : 0.0; },
    .set = [](Tool& t, double v) { t.soft = v >= 0.5; },
};
inline constexpr Row kEvenOut{
    .id = "even_out",
    .name = "Coarse bumps",
    .help = "Larger values even out coarser bumps in one pass.",
    .unit = "×",
    .low = 1,
    .high = 64,
    .standard = 1,
    .logarithmic = true,
    .get = [](const Tool& t) { return t.evenOut; },
    .set = [](Tool& t, double v) { t.evenOut = v; },
};
inline constexpr Row kBlend{
    .id = "blend",
    .name = "Blend",
    .help = "Width over which new clay runs into the old.",
    .unit = "mm",
    .low = 0,
    .high = 20,
    .standard = 1,
    .get = [](const Tool& t) { return t.blendMm; },
    .set = [](Tool& t, double v) { t.blendMm = v; },
};
inline constexpr Row kLeastWall{
    .id = "least_wall",
    .name = "Least wall",
    .help = "No wall is cut thinner than this: the tool stops there; 0: no limit.",
    .unit = "mm",
    .low = 0,
    .high = 100,
    .standard = 0,
    .get = [](const Tool& t) { return t.leastWallMm; },
    .set = [](Tool& t, double v) { t.leastWallMm = v; },
    .zero = "no limit",
};
inline constexpr Row kAngle{
    .id = "angle",
    .name = "Angle",
    .help = "How far it turns while the tip moves by its radius.",
    .unit = "°",
    .low = -180,
    .high = 180,
    .standard = 45,
    .get = [](const Tool& t) { return t.angleDeg; },
    .set = [](Tool& t, double v) { t.angleDeg = v; },
};
inline constexpr Row kFalloff{
    .id = "falloff",
    .name = "Falloff",
    .help = "How its strength fades towards the rim.",
    .unit = "",
    .low = 0,
    .high = 4,
    .standard = 1,
    .get = [](const Tool& t) { return double(t.falloff); },
    .set = [](Tool& t, double v) { t.falloff = clay::Falloff(int(v)); },
    .choices = kFalloffs,
};
inline constexpr Row kTip{
    .id = "tip",
    .name = "Tip",
    .help = "The solid that it works with; a stylus turns it.",
    .unit = "",
    .low = 0,
    .high = 2,
    .standard = 0,
    .get = [](const Tool& t) { return double(t.tip); },
    .set = [](Tool& t, double v) { t.tip = clay::Tip(int(v)); },
    .choices = kTips,
};
inline constexpr Row kBreadth{
    .id = "breadth",
    .name = "Breadth",
    .help = "Of the tip beside its length.",
    .unit = "share",
    .low = 0.05,
    .high = 1,
    .standard = 1,
    .get = [](const Tool& t) { return t.breadth; },
    .set = [](Tool& t, double v) { t.breadth = v; },
};
inline constexpr Row kThickness{
    .id = "thickness",
    .name = "Thickness",
    .help = "Of the tip beside its length.",
    .unit = "share",
    .low = 0.05,
    .high = 1,
    .standard = 1,
    .get = [](const Tool& t) { return t.thickness; },
    .set = [](Tool& t, double v) { t.thickness = v; },
};
inline constexpr Row kRound{
    .id = "round",
    .name = "Roundness",
    .help = "Of the edges of a box.",
    .unit = "share",
    .low = 0,
    .high = 1,
    .standard = 0.2,
    .get = [](const Tool& t) { return t.round; },
    .set = [](Tool& t, double v) { t.round = v; },
};
inline constexpr Row kColour{
    .id = "colour",
    .name = "Colour",
    .help = "What it paints.",
    .unit = "colour",
    .low = 0,
    .high = 0xffffff,
    .standard = 0xc8402e,
    .get = [](const Tool& t) { return double(t.colour); },
    .set = [](Tool& t, double v) { t.colour = uint32_t(v); },
};
inline constexpr Row kMaterial{
    .id = "material",
    .name = "Material",
    .help = "Row of the piece's materials; 0 is its own.",
    .unit = "",
    .low = 0,
    .high = 255,
    .standard = 1,
    .get = [](const Tool& t) { return double(t.material); },
    .set = [](Tool& t, double v) { t.material = int(v); },
};
inline constexpr Row kMorphTo{
    .id = "morph_to",
    .name = "Back to step",
    .help = "The clay after so many steps; 0 is the beginning.",
    .unit = "",
    .low = 0,
    .high = 100000,
    .standard = 0,
    .get = [](const Tool& t) { return double(t.morphTo); },
    .set = [](Tool& t, double v) { t.morphTo = int(v); },
};
inline constexpr Row kStabilise{
    .id = "stabilise",
    .name = "Stabiliser",
    .help = "The tool is drawn on a string of this length, so that a shaky hand draws a smooth line.",
    .unit = "mm",
    .low = 0,
    .high = 50,
    .standard = 0,
    .get = [](const Tool& t) { return t.stabiliseMm; },
    .set = [](Tool& t, double v) { t.stabiliseMm = v; },
};
constexpr Row pressureRadius(double standard) {
  return {
      .id = "radius_by_pressure",
      .name = "Pressure on radius",
      .help = "Share of the radius that the pressure rules.",
      .unit = "share",
      .low = 0,
      .high = 1,
      .standard = standard,
      .get = [](const Tool& t) { return t.radiusByPressure; },
      .set = [](Tool& t, double v) { t.radiusByPressure = v; },
  };
}
constexpr Row pressureStrength(double standard) {
  return {
      .id = "strength_by_pressure",
      .name = "Pressure on strength",
      .help = "Share of the strength that the pressure rules.",
      .unit = "share",
      .low = 0,
      .high = 1,
      .standard = standard,
      .get = [](const Tool& t) { return t.strengthByPressure; },
      .set = [](Tool& t, double v) { t.strengthByPressure = v; },
  };
}
inline constexpr Row kPressureCurve{
    .id = "pressure_curve",
    .name = "Pressure curve",
    .help = "Below zero a light touch does much already; above, little.",
    .unit = "",
    .low = -1,
    .high = 1,
    .standard = 0,
    .get = [](const Tool& t) { return t.pressureCurve; },
    .set = [](Tool& t, double v) { t.pressureCurve = v; },
};
inline constexpr Row kForce{
    .id = "pressure_is_force",
    .name = "Force is pressure",
    .help = "The force that is felt rules radius and strength, not a pen's pressure.",
    .unit = "on",
    .low = 0,
    .high = 1,
    .standard = 0,
    .get = [](const Tool& t) { return t.pressureIsForce ? 1.0 : 0.0; },
    .set = [](Tool& t, double v) { t.pressureIsForce = v >= 0.5; },
};
inline constexpr Row kFullForce{
    .id = "full_force",
    .name = "Full force",
    .help = "The force that counts as full pressure.",
    .unit = "N",
    .low = 0.2,
    .high = 20,
    .standard = 3,
    .logarithmic = true,
    .get = [](const Tool& t) { return t.fullForceN; },
    .set = [](Tool& t, double v) { t.fullForceN = v; },
};

}  // namespace argil::engine::tool_parameters
