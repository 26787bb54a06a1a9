#include "engine/tools/tool_table.h"

#include <algorithm>
#include <array>
#include <numbers>
#include <utility>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/brush/formula.h"
#include "engine/tools/added_tools.h"
#include "engine/tools/stroke_path.h"
#include "engine/tools/tool_parameters.h"

namespace argil::engine {
namespace {

using clay::Falloff;
using clay::Method;
using clay::Operation;
using clay::Property;
using clay::Tip;
using haptics::Work;

using namespace tool_parameters;

// What every tool has comes last; before it, what a pen's pressure rules as the tool begins. A touch that has hardly
// any pressure still does a tenth of the work, so that a stroke's first samples are not lost. Where a solid is laid or
// set there is no strength: there it is the radius. A carving tip goes deeper by pressure (PressureRules::depth);
// tugged clay stays under the hand at any pressure.
#define ARGIL_HELD(radius, strength) \
  kStabilise, pressureRadius(radius), pressureStrength(strength), kPressureCurve, kForce, kFullForce
#define ARGIL_BY_DEPTH ARGIL_HELD(0, 0)
#define ARGIL_BY_RADIUS ARGIL_HELD(0.6, 0)
#define ARGIL_BY_STRENGTH ARGIL_HELD(0, 0.9)
constexpr std::array kCut{kRadius, kSoftCut, kDepth, kLeastWall, kTip, kBreadth, kThickness, kRound, ARGIL_BY_DEPTH};
constexpr std::array kSolid{kRadius, kTip, kBreadth, kThickness, kRound, ARGIL_BY_RADIUS};
constexpr std::array kWax{kRadius, kBlend, kTip, kBreadth, kThickness, kRound, ARGIL_BY_RADIUS};
constexpr std::array kClay{kRadius, kBuildUp, kStrength, kFalloff, ARGIL_BY_STRENGTH};
constexpr std::array kSoft{kRadius, kStrength, kFalloff, ARGIL_BY_STRENGTH};
constexpr std::array kEven{kRadius, kStrength, kEvenOut, kFalloff, ARGIL_BY_STRENGTH};
constexpr std::array kGrip{kRadius, kStrength, kFalloff, ARGIL_BY_RADIUS};
constexpr std::array kRaise{kRadius, kHeight, kStrength, kFalloff, ARGIL_BY_STRENGTH};
constexpr std::array kTwist{kRadius, kAngle, kStrength, kFalloff, ARGIL_BY_STRENGTH};
constexpr std::array kStamp{kRadius, ARGIL_BY_RADIUS};
constexpr std::array kPaint{kRadius, kColour, kStrength, kFalloff, ARGIL_BY_STRENGTH};
constexpr std::array kSquirt{kRadius, kHeight, kColour, kStrength, kFalloff, ARGIL_BY_STRENGTH};
constexpr std::array kStampPaint{kRadius, kColour, kMaterial, ARGIL_BY_RADIUS};
constexpr std::array kDull{kRadius, kMaterial, ARGIL_BY_RADIUS};
constexpr std::array kMorph{kRadius, kMorphTo, kStrength, kFalloff, ARGIL_BY_STRENGTH};
#undef ARGIL_BY_DEPTH
#undef ARGIL_BY_RADIUS
#undef ARGIL_BY_STRENGTH
#undef ARGIL_HELD

constexpr std::array kClayOps{Operation{Property::distance, Method::build}};
constexpr std::array kCarveOps{Operation{Property::distance, Method::carve}};
constexpr std::array kAddOps{Operation{Property::distance, Method::add}};
constexpr std::array kWaxOps{Operation{Property::distance, Method::wax}};
constexpr std::array kSmoothOps{Operation{Property::distance, Method::smooth}};
constexpr std::array kPolishOps{Operation{Property::distance, Method::smoothKeep}};
constexpr std::array kScrapeOps{Operation{Property::distance, Method::scrape}};
constexpr std::array kFillOps{Operation{Property::distance, Method::fill}};
constexpr std::array kFlattenOps{Operation{Property::distance, Method::flatten}};
constexpr std::array kRaiseOps{Operation{Property::distance, Method::raise}};
constexpr std::array kLowerOps{Operation{Property::distance, Method::raise, Falloff::smooth, -1}};
constexpr std::array kCreaseOps{Operation{Property::distance, Method::crease, Falloff::smooth, -1}};
constexpr std::array kPinchOps{Operation{Property::distance, Method::pinch}};
constexpr std::array kTugOps{Operation{Property::distance, Method::tug}};
constexpr std::array kSmudgeOps{Operation{Property::distance, Method::smudge}};
constexpr std::array kTwistOps{Operation{Property::distance, Method::twist}};
constexpr std::array kMorphOps{Operation{Property::distance, Method::morph}};
constexpr std::array kPaintOps{Operation{Property::colour, Method::set, Falloff::constant}};
constexpr std::array kAirbrushOps{Operation{Property::colour, Method::set, Falloff::smooth, 0.3f}};
constexpr std::array kBlendOps{Operation{Property::colour, Method::blur}};
constexpr std::array kMaterialOps{Operation{Property::material, Method::set, Falloff::constant}};
constexpr std::array kMaskOps{Operation{Property::mask, Method::set}};
constexpr std::array kMaskBlurOps{Operation{Property::mask, Method::blur}};
constexpr std::array kBurnOps{Operation{Property::distance, Method::raise, Falloff::smooth, -1},
                              Operation{Property::colour, Method::set, Falloff::smooth, 0.5f}};
constexpr std::array kSquirtOps{Operation{Property::distance, Method::raise},
                                Operation{Property::colour, Method::set, Falloff::smooth}};
constexpr std::array kStampPaintOps{Operation{Property::distance, Method::add},
                                    Operation{Property::colour, Method::set, Falloff::constant},
                                    Operation{Property::material, Method::set, Falloff::constant}};

// The source's own tools (Avila and Sobierajski, table 2) are the last group but for those that have a place above: its
// Paint and Airbrush.
constexpr std::array kTools{
    ToolRow{
        .id = "clay",
        .name = "Clay",
        .help = "Builds clay up softly and evenly; more with every pass.",
        .icon = "clay",
        .key = "B",
        .group = "Clay",
        .operations = kClayOps,
        .work = Work::rub,
        .opposite = "clay",
        .parameters = kClay,
    },
    ToolRow{
        .id = "carve",
        .name = "Carve",
        .help = "Cuts clay away where the tip goes.",
        .icon = "carve",
        .key = "C",
        .group = "Clay",
        .operations = kCarveOps,
        .work = Work::cut,
        .opposite = "add",
        .parameters = kCut,
    },
    ToolRow{
        .id = "add",
        .name = "Add",
        .help = "Lays clay along the stroke.",
        .icon = "add",
        .key = "A",
        .group = "Clay",
        .operations = kAddOps,
        .work = Work::lay,
        .opposite = "carve",
        .parameters = kSolid,
    },
    ToolRow{
        .id = "wax",
        .name = "Hot wax",
        .help = "Lays clay that runs into what is there.",
        .icon = "wax",
        .key = "W",
        .group = "Clay",
        .operations = kWaxOps,
        .work = Work::lay,
        .opposite = "carve",
        .parameters = kWax,
    },
    ToolRow{
        .id = "stamp",
        .name = "Stamp",
        .help = "Lays a shape from a file, or cuts it out.",
        .icon = "stamp",
        .group = "Clay",
        .operations = kAddOps,
        .work = Work::lay,
        .opposite = "stamp",
        .parameters = kStamp,
        .file = ToolFile::shape,
        .tip = Tip::shape,
    },
    ToolRow{
        .id = "smooth",
        .name = "Smooth",
        .help = "Evens out bumps and edges.",
        .icon = "smooth",
        .key = "S",
        .group = "Surface",
        .operations = kSmoothOps,
        .work = Work::rub,
        .parameters = kEven,
        .strength = 0.5,
    },
    ToolRow{
        .id = "polish",
        .name = "Polish",
        .help = "Evens out and keeps the volume.",
        .icon = "polish",
        .group = "Surface",
        .operations = kPolishOps,
        .work = Work::rub,
        .parameters = kSoft,
        .strength = 0.5,
    },
    ToolRow{
        .id = "scrape",
        .name = "Scrape",
        .help = "Takes away what stands above the surface around it.",
        .icon = "scrape",
        .group = "Surface",
        .operations = kScrapeOps,
        .work = Work::rub,
        .opposite = "fill",
        .parameters = kSoft,
    },
    ToolRow{
        .id = "fill",
        .name = "Fill",
        .help = "Fills what lies below the surface around it.",
        .icon = "fill",
        .group = "Surface",
        .operations = kFillOps,
        .work = Work::rub,
        .opposite = "scrape",
        .parameters = kSoft,
    },
    ToolRow{
        .id = "flatten",
        .name = "Flatten",
        .help = "Scrapes and fills to a plane.",
        .icon = "flatten",
        .group = "Surface",
        .operations = kFlattenOps,
        .work = Work::rub,
        .parameters = kSoft,
    },
    ToolRow{
        .id = "layer",
        .name = "Layer",
        .help = "One even layer, however often it is gone over.",
        .icon = "layer",
        .group = "Surface",
        .operations = kRaiseOps,
        .work = Work::rub,
        .opposite = "layer",
        .parameters = kRaise,
        .limited = true,
    },
    ToolRow{
        .id = "inflate",
        .name = "Inflate",
        .help = "Swells the clay along its normals.",
        .icon = "inflate",
        .group = "Surface",
        .operations = kRaiseOps,
        .work = Work::rub,
        .opposite = "inflate",
        .parameters = kRaise,
    },
    ToolRow{
        .id = "groove",
        .name = "Groove",
        .help = "A channel along the stroke.",
        .icon = "groove",
        .group = "Surface",
        .operations = kLowerOps,
        .work = Work::rub,
        .opposite = "ridge",
        .parameters = kRaise,
        .limited = true,
        .bead = true,
    },
    ToolRow{
        .id = "ridge",
        .name = "Ridge",
        .help = "A bead along the stroke.",
        .icon = "ridge",
        .group = "Surface",
        .operations = kRaiseOps,
        .work = Work::rub,
        .opposite = "groove",
        .parameters = kRaise,
        .limited = true,
        .bead = true,
    },
    ToolRow{
        .id = "crease",
        .name = "Crease",
        .help = "Draws the clay together into a sharp valley, or a sharp ridge.",
        .icon = "crease",
        .group = "Surface",
        .operations = kCreaseOps,
        .work = Work::rub,
        .opposite = "crease",
        .parameters = kRaise,
    },
    ToolRow{
        .id = "emboss",
        .name = "Emboss",
        .help = "Presses an image into the surface.",
        .icon = "emboss",
        .group = "Surface",
        .operations = kRaiseOps,
        .work = Work::rub,
        .opposite = "emboss",
        .parameters = kRaise,
        .limited = true,
        .file = ToolFile::image,
        .falloff = Falloff::constant,
    },
    ToolRow{
        .id = "tug",
        .name = "Tug",
        .help = "Takes the clay along.",
        .icon = "tug",
        .group = "Move",
        .operations = kTugOps,
        .work = Work::rub,
        .parameters = kGrip,
    },
    ToolRow{
        .id = "smudge",
        .name = "Smudge",
        .help = "Smears the clay along.",
        .icon = "smudge",
        .group = "Move",
        .operations = kSmudgeOps,
        .work = Work::rub,
        .parameters = kSoft,
        .strength = 0.5,
    },
    ToolRow{
        .id = "pinch",
        .name = "Pinch",
        .help = "Draws the clay towards the stroke, or pushes it apart.",
        .icon = "pinch",
        .key = "P",
        .group = "Move",
        .operations = kPinchOps,
        .work = Work::rub,
        .opposite = "pinch",
        .parameters = kSoft,
        .strength = 0.5,
    },
    ToolRow{
        .id = "twist",
        .name = "Twist",
        .help = "Turns the clay about the tool.",
        .icon = "twist",
        .group = "Move",
        .operations = kTwistOps,
        .work = Work::rub,
        .opposite = "twist",
        .parameters = kTwist,
    },
    ToolRow{
        .id = "morph",
        .name = "Morph back",
        .help = "Brings back what an earlier step had.",
        .icon = "morph",
        .group = "Move",
        .operations = kMorphOps,
        .work = Work::rub,
        .parameters = kMorph,
        .strength = 0.5,
    },
    ToolRow{
        .id = "paint",
        .name = "Paint",
        .help = "Colours the clay.",
        .icon = "paint",
        .group = "Paint",
        .operations = kPaintOps,
        .work = Work::rub,
        .opposite = "paint",
        .parameters = kPaint,
        .falloff = Falloff::constant,
    },
    ToolRow{
        .id = "airbrush",
        .name = "Airbrush",
        .help = "A breath of colour.",
        .icon = "airbrush",
        .group = "Paint",
        .operations = kAirbrushOps,
        .work = Work::rub,
        .opposite = "airbrush",
        .parameters = kPaint,
    },
    ToolRow{
        .id = "blend",
        .name = "Blend colours",
        .help = "Lets colours run into each other.",
        .icon = "blend",
        .group = "Paint",
        .operations = kBlendOps,
        .work = Work::rub,
        .parameters = kSoft,
    },
    ToolRow{
        .id = "material",
        .name = "Material",
        .help = "Sets how the clay feels.",
        .icon = "material",
        .group = "Paint",
        .operations = kMaterialOps,
        .work = Work::rub,
        .opposite = "material",
        .parameters = kDull,
        .falloff = Falloff::constant,
    },
    ToolRow{
        .id = "mask",
        .name = "Mask",
        .help = "Protects clay from every tool; inverted it frees it.",
        .icon = "mask",
        .key = "M",
        .group = "Paint",
        .operations = kMaskOps,
        .work = Work::rub,
        .opposite = "mask",
        .parameters = kSoft,
    },
    ToolRow{
        .id = "blur_mask",
        .name = "Soften mask",
        .help = "Softens the rim of a mask.",
        .icon = "blur_mask",
        .group = "Paint",
        .operations = kMaskBlurOps,
        .work = Work::rub,
        .parameters = kSoft,
    },
    ToolRow{
        .id = "melt",
        .name = "Melt",
        .help = "Lets clay run away from under the tool.",
        .icon = "melt",
        .group = "Lab",
        .operations = kLowerOps,
        .work = Work::rub,
        .opposite = "construct",
        .parameters = kRaise,
    },
    ToolRow{
        .id = "construct",
        .name = "Construct",
        .help = "Lets clay grow under the tool.",
        .icon = "construct",
        .group = "Lab",
        .operations = kRaiseOps,
        .work = Work::rub,
        .opposite = "melt",
        .parameters = kRaise,
    },
    ToolRow{
        .id = "burn",
        .name = "Burn",
        .help = "Melts and blackens.",
        .icon = "burn",
        .group = "Lab",
        .operations = kBurnOps,
        .work = Work::rub,
        .parameters = kSquirt,
    },
    ToolRow{
        .id = "squirt",
        .name = "Squirt",
        .help = "Lets clay of the tool's colour grow.",
        .icon = "squirt",
        .group = "Lab",
        .operations = kSquirtOps,
        .work = Work::rub,
        .opposite = "squirt",
        .parameters = kSquirt,
        .dye = true,
    },
    ToolRow{
        .id = "stamp_paint",
        .name = "Coloured stamp",
        .help = "Lays a shape of the tool's colour and material.",
        .icon = "stamp",
        .group = "Lab",
        .operations = kStampPaintOps,
        .work = Work::lay,
        .opposite = "stamp_paint",
        .parameters = kStampPaint,
        .dye = true,
        .file = ToolFile::shape,
        .tip = Tip::shape,
    },
    ToolRow{
        .id = "invisible",
        .name = "Invisible",
        .help = "Makes clay unseen; it can still be felt.",
        .icon = "invisible",
        .group = "Lab",
        .operations = kMaterialOps,
        .work = Work::rub,
        .opposite = "invisible",
        .parameters = kDull,
        .falloff = Falloff::constant,
    },
};

constexpr int kInvisibleMaterial = 255;
constexpr uint32_t kBlack = 0x101010;

}  // namespace

std::span<const ToolRow> ownTools() {
  return kTools;
}

std::span<const ToolRow> toolTable() {
  return addedTools().all();
}

const ToolRow* findTool(std::string_view id) {
  const std::span<const ToolRow> rows = toolTable();
  const auto row = std::find_if(rows.begin(), rows.end(), [&](const ToolRow& each) { return each.id == id; });
  return row == rows.end() ? nullptr : &*row;
}

const ToolRow& rowOf(const Tool& tool) {
  const ToolRow* row = findTool(tool.id);
  if (!row) throw Error(fmt::format("there is no tool named \"{}\"", tool.id));
  return *row;
}

const Parameter<Tool>* findParameter(const ToolRow& row, std::string_view id) {
  const auto found = std::find_if(row.parameters.begin(), row.parameters.end(),
                                  [&](const Parameter<Tool>& each) { return each.id == id; });
  return found == row.parameters.end() ? nullptr : &*found;
}

Tool standardTool(const ToolRow& row) {
  Tool tool;
  for (const Parameter<Tool>& parameter : row.parameters) parameter.change(tool, parameter.standard);
  tool.id = row.id;
  tool.falloff = row.falloff;
  tool.tip = row.tip;
  tool.strength = row.strength;
  if (row.id == "burn") tool.colour = kBlack;
  if (row.id == "invisible") tool.material = kInvisibleMaterial;
  return tool;
}

Tool scriptTool(const ToolRow& row) {
  Tool tool = standardTool(row);
  tool.radiusByPressure = tool.strengthByPressure = 0;
  return tool;
}

bool cutsSoftly(const Tool& tool) {
  return tool.soft && rowOf(tool).work == Work::cut;
}

Work workOf(const Tool& tool) {
  return cutsSoftly(tool) ? Work::rub : rowOf(tool).work;
}

PressureRules pressureRules(const ToolRow& row) {
  if (row.work == Work::cut) return PressureRules::depth;
  return standardTool(row).radiusByPressure > 0 ? PressureRules::radius : PressureRules::strength;
}

std::shared_ptr<const clay::Brush> brushOf(const Tool& tool, const clay::Grid& grid, const clay::Version& before) {
  const ToolRow& row = rowOf(tool);
  if (!(tool.strength >= 0 && tool.strength <= 1))
    throw Error(fmt::format("a strength of {} is out of range; choose 0 to 1", tool.strength));
  auto brush = std::make_shared<clay::Brush>();
  const bool soft = cutsSoftly(tool);
  const bool turned = tool.inverted && row.opposite == row.id;
  for (Operation operation : row.operations) {
    operation.shape =
        operation.property == Property::distance || row.operations.size() == 1 ? tool.falloff : operation.shape;
    if (turned && operation.method == Method::add)
      operation.method = Method::carve;
    else if (turned && operation.method == Method::carve)
      operation.method = Method::add;
    else if (turned)
      operation.amount = -operation.amount;
    if (soft && operation.method == Method::carve) operation = {Property::distance, Method::raise, Falloff::smooth, -1};
    brush->operations.push_back(operation);
  }
  const auto voxels = [&](double mm) { return static_cast<float>(mm / grid.voxelMm); };
  brush->tip = tool.tip;
  brush->proportions = Vec3f(1, static_cast<float>(tool.breadth), static_cast<float>(tool.thickness));
  brush->round = static_cast<float>(tool.round);
  brush->blend = std::min(voxels(tool.blendMm), 64.0f);
  const bool byRadius = soft || row.operations.front().method == Method::build;
  brush->height = std::min(voxels(byRadius ? tool.depth * tool.radiusMm : tool.heightMm), 4096.0f);
  brush->spread = row.operations.front().method == Method::smooth ? tool.evenOut : 1;
  const bool carves = std::any_of(brush->operations.begin(), brush->operations.end(),
                                  [](const Operation& each) { return each.method == Method::carve; });
  brush->leastWall = carves ? std::min(voxels(tool.leastWallMm), 256.0f) : 0;
  brush->limited = row.limited || soft;
  brush->bead = row.bead;
  brush->angle = static_cast<float>(tool.angleDeg * std::numbers::pi / 180);
  brush->colour = {uint8_t(tool.colour >> 16), uint8_t(tool.colour >> 8), uint8_t(tool.colour)};
  brush->material = static_cast<uint8_t>(std::clamp(tool.material, 0, 255));
  brush->dye = row.dye;
  brush->shape = tool.content.shape;
  brush->image = tool.content.image;
  brush->before = before;
  if (const AddedTool* added = addedTools().addedAs(row)) {
    // The table holds it as long as the program runs.
    brush->formula = std::shared_ptr<const clay::Formula>(std::shared_ptr<void>(), row.formula);
    brush->external = added->external;
    brush->adds = row.adds;
    for (size_t i = 0; i < added->numbers.size(); ++i) brush->values.push_back(static_cast<float>(tool.own[i]));
    if (added->image) brush->image = added->image(std::exchange(brush->values, {}));
  }
  brush->quality = tool.quality.clay;
  // What the stamps of a pass add up to where its middle goes is the area below the smooth falloff, 16/15 of a radius,
  // and the way of one of them, over that way.
  const auto share = [&](const Tool& of) {
    const double radii = stampSpacing(of, grid) * grid.voxelMm / of.radiusMm;
    return radii / (16.0 / 15 + radii);
  };
  if (!(tool.quality == StrokeQuality())) brush->perStamp = share(tool) / share({.radiusMm = tool.radiusMm});
  if (row.file == ToolFile::image && !tool.content.image)
    throw Error(fmt::format("the tool {} needs an image: choose one", row.name));
  if (row.file == ToolFile::shape && !tool.content.shape)
    throw Error(fmt::format("the tool {} needs a shape: choose a file of one", row.name));
  brush->check();
  return brush;
}

}  // namespace argil::engine
