#include "ui3d/studio/panels/settings_tables.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "engine/document/guide_table.h"

namespace argil::studio {
namespace {

using engine::Guide;
using haptics::Material;
using haptics::PanWalls;
using haptics::Workspace;
using render::Look;
using render::Stereo;
using std::string_view;

// A number that is a member, in its own unit.
template <class Owner, auto member>
constexpr engine::Parameter<Owner> plain(string_view id, string_view name, string_view help, string_view unit,
                                         double low, double high, double standard, bool logarithmic = false) {
  return {id,
          name,
          help,
          unit,
          low,
          high,
          standard,
          logarithmic,
          [](const Owner& o) { return double(o.*member); },
          [](Owner& o, double v) {
            using Number = std::remove_reference_t<decltype(o.*member)>;
            if constexpr (std::is_integral_v<Number>)
              o.*member = static_cast<Number>(std::lround(v));
            else
              o.*member = static_cast<Number>(v);
          }};
}
// A part of one, shown in percent.
template <class Owner, auto member>
constexpr engine::Parameter<Owner> percent(string_view id, string_view name, string_view help, double low, double high,
                                           double standard, bool logarithmic = false) {
  return {id,
          name,
          help,
          "%",
          low,
          high,
          standard,
          logarithmic,
          [](const Owner& o) { return 100.0 * double(o.*member); },
          [](Owner& o, double v) { o.*member = static_cast<std::remove_reference_t<decltype(o.*member)>>(v / 100); }};
}
// An enumeration whose values count from 0.
template <class Owner, auto member>
constexpr Choice<Owner> oneOf(string_view id, string_view name, string_view help,
                              std::span<const string_view> options) {
  return {id,
          name,
          help,
          options,
          [](const Owner& o) { return int(o.*member); },
          [](Owner& o, int v) { o.*member = static_cast<std::remove_reference_t<decltype(o.*member)>>(v); }};
}

constexpr std::array<string_view, 3> kShadings{"Matcap", "Lit", "Material"};
constexpr std::array<string_view, 6> kMatcaps{"Clay", "Wax", "Porcelain", "Steel", "Rubber", "Normals"};
const std::array<Row<Look>, 13> kLook{
    oneOf<Look, &Look::shading>("shading", "Shading",
                                "Matcap shows form at a glance; lit uses lights; material adds gloss.", kShadings),
    oneOf<Look, &Look::matcap>("matcap", "Matcap", "The material that the matcap shading shows.", kMatcaps),
    Switch<Look>{"cavity", "Cavity", "Darker hollows, lighter ridges.", &Look::cavity},
    percent<Look, &Look::cavityStrength>("cavityStrength", "Cavity strength", "How dark hollows are.", 0, 200, 100),
    Switch<Look>{"keyShadow", "Shadows", "Clay shades itself and the ground.", &Look::keyShadow},
    Switch<Look>{"cursorShadow", "Tool's shadow", "Says how high the tool is above the clay.", &Look::cursorShadow},
    Switch<Look>{"beam", "Drop beam", "From the tool to where it would land.", &Look::beam},
    Switch<Look>{"depthFade", "Depth fade", "What is farther away fades towards the background.", &Look::depthFade},
    percent<Look, &Look::depthFadeStrength>("depthFadeStrength", "Fade strength", "Of the farthest point of the clay.",
                                            0, 100, 60),
    Switch<Look>{"grid", "Ground and grid", "Lines at round numbers of millimetres.", &Look::grid},
    Switch<Look>{"scaleBar", "Scale bar", "A length in the plane of what is looked at.", &Look::scaleBar},
    Switch<Look>{"xray", "X-ray of guides", "Guides show faintly through the clay.", &Look::xray},
    Switch<Look>{"lightBackground", "Light background", "Behind the clay.", &Look::lightBackground},
};

constexpr std::array<string_view, 6> kModes{"Off",      "Red and cyan", "Side by side", "Top and bottom",
                                            "Left eye", "Right eye"};
const std::array<Row<Stereo>, 4> kStereo{
    oneOf<Stereo, &Stereo::mode>("mode", "Stereo", "How the two pictures reach the two eyes.", kModes),
    percent<Stereo, &Stereo::eyeDistancePart>("eyeDistance", "Eye distance",
                                              "As a part of the distance to what is looked at.", 0, 20, 3.5),
    percent<Stereo, &Stereo::convergencePart>("convergence", "Screen plane",
                                              "What lies there seems to lie in the screen; 100 % is what is looked at.",
                                              20, 500, 100, true),
    Switch<Stereo>{"swapEyes", "Swap eyes", "When depth seems turned inside out.", &Stereo::swapEyes},
};

using RenderQuality = render::Quality;
const std::array<Row<RenderQuality>, 5> kQuality{
    plain<RenderQuality, &RenderQuality::supersample>(
        "supersample", "Samples", "A pixel, along each edge: 2 are four samples. Cost grows with the square.", "", 1, 4,
        2),
    Switch<RenderQuality>{"keyShadow", "Shadow pass", "One more pass over the triangles.", &RenderQuality::keyShadow},
    plain<RenderQuality, &RenderQuality::shadowPixels>(
        "shadowPixels", "Shadow map", "Edge of the map: finer shadows need more of the device's memory.", "px", 256,
        8192, 2048, true),
    Switch<RenderQuality>{"cavity", "Cavity pass", "One more pass over the pixels.", &RenderQuality::cavity},
    plain<RenderQuality, &RenderQuality::detailPixels>(
        "detailPixels", "Detail", "Triangles coarser than this may stand for finer ones; 0: never.", "px", 0, 8, 1),
};

constexpr std::array<string_view, 3> kGrades{"Draft", "Crisp", "Fine"};
const std::array<Row<StudioState>, 2> kPicture{
    oneOf<StudioState, &StudioState::surface>(
        "surface", "Surface",
        "Crisp shows creases sharp at little cost; fine puts them exactly and costs much where there are some.",
        kGrades),
    plain<StudioState, &StudioState::framesPerSecond>(
        "framesPerSecond", "Frames", "Drawn a second at most: more for a fast display, fewer to spare a battery.", "/s",
        StudioState::kLeastFrames, StudioState::kMostFrames, StudioState::kUsualFrames, true),
};

// The servo's rate is that of the device.
std::vector<engine::Parameter<engine::Quality>> axesOf(engine::QualityPart part) {
  std::vector<engine::Parameter<engine::Quality>> rows;
  for (const engine::QualityAxis& axis : engine::qualityAxes())
    if (axis.part == part && axis.row.id != "servo-hz") rows.push_back(axis.row);
  return rows;
}

constexpr std::array<string_view, 3> kFrames{"As the device", "Left-handed", "Right-handed"};
const std::array<Row<Workspace>, 4> kWorkspace{
    plain<Workspace, &Workspace::scale>("scale", "Scale", "Millimetres of clay for each millimetre of hand.", "×", 0.01,
                                        100, 1, true),
    plain<Workspace, &Workspace::depthMm>("depthMm", "Depth", "Moves the hand's reach towards the person.", "mm", -500,
                                          500, 0),
    oneOf<Workspace, &Workspace::frame>("frame", "Axes", "Left-handed axes mirror x.", kFrames),
    plain<Workspace, &Workspace::glideMms>(
        "glideMms", "Glide", "Of the tip to its new place after the reach was moved; 0: never.", "mm/s", 0, 1000, 100),
};
const std::array<Row<PanWalls>, 5> kWalls{
    Switch<PanWalls>{"on", "Pan walls", "A box in the device's reach; its walls move the reach when they are pressed.",
                     &PanWalls::on},
    percent<PanWalls, &PanWalls::share>("share", "Box", "Edges of the box in those of the device's reach.", 10, 100,
                                        85),
    plain<PanWalls, &PanWalls::stiffnessNmm>("stiffnessNmm", "Wall stiffness", "Never above the device's own limit.",
                                             "N/mm", 0.01, 10, 0.4, true),
    plain<PanWalls, &PanWalls::restMm>("restMm", "Rest", "So deep in a wall nothing moves yet.", "mm", 0, 10, 1),
    plain<PanWalls, &PanWalls::speedMmsN>("speedMmsN", "Speed", "Of the tip for each newton.", "mm/s", 0, 1000, 30),
};

constexpr std::array kMaterial{
    plain<Material, &Material::stiffnessNmm>(
        "stiffnessNmm", "Stiffness", "Of the surface; never above the device's own limit.", "N/mm", 0.01, 20, 1, true),
    plain<Material, &Material::hardnessNmm2>("hardnessNmm2", "Hardness", "The pressure at which it yields to a cut.",
                                             "N/mm²", 0.001, 5, 0.05, true),
    plain<Material, &Material::viscosityNsmm>("viscosityNsmm", "Viscosity", "How slowly it yields.", "N·s/mm", 0.0001,
                                              1, 0.01, true),
    plain<Material, &Material::dragNsmm>("dragNsmm", "Drag", "Against the motion of a tool that cuts.", "N·s/mm",
                                         0.0001, 0.1, 0.002, true),
    engine::Parameter<Material>{
        .id = "staticFriction",
        .name = "Static friction",
        .help = "A tool at rest stays while it is pushed less than this part of its weight.",
        .unit = "",
        .low = 0,
        .high = 4,
        .standard = 0,
        .get = [](const Material& m) { return m.staticFriction; },
        .set =
            [](Material& m, double v) {
              m.staticFriction = v;
              if (m.dynamicFriction > v) m.dynamicFriction = v;
            },
    },
    engine::Parameter<Material>{
        .id = "dynamicFriction",
        .name = "Sliding friction",
        .help = "Of a tool that slides; at most the static one.",
        .unit = "",
        .low = 0,
        .high = 4,
        .standard = 0,
        .get = [](const Material& m) { return m.dynamicFriction; },
        .set =
            [](Material& m, double v) {
              m.dynamicFriction = v;
              if (m.staticFriction < v) m.staticFriction = v;
            },
    },
};

constexpr std::array kWell{
    plain<Guide, &Guide::rangeMm>("rangeMm", "Range", "The tool is drawn from so far away.", "mm", 0.1, 100, 5, true),
    plain<Guide, &Guide::forceN>("forceN", "Force", "The largest pull; at most half of the device's peak is given.",
                                 "N", 0.05, 5, 1, true),
};
template <int axis>
constexpr engine::Parameter<Guide> edge(string_view id, string_view name) {
  return {id,
          name,
          "Of what is drawn; of a box its edge.",
          "mm",
          0.1,
          1000,
          40,
          true,
          [](const Guide& g) { return g.sizeMm[axis]; },
          [](Guide& g, double v) { g.sizeMm[axis] = v; }};
}
constexpr std::array kEdges{edge<0>("sizeX", "Width"), edge<1>("sizeY", "Depth"), edge<2>("sizeZ", "Height")};
constexpr std::array kLength{edge<2>("sizeZ", "Length")};

constexpr std::array kSymmetry{
    plain<engine::Symmetry, &engine::Symmetry::turns>(
        "turns", "Around z", "Strokes are repeated so many times around the z axis of the symmetry.", "×", 1,
        engine::kMostTurns, 1),
};

constexpr std::array kHand{
    percent<StudioState, &StudioState::pointerDepthMm>(
        "pointerDepth", "Pointer depth", "How deep mouse and pen go under the surface, as a part of the radius.", 0,
        100, 60),
};

constexpr std::array<string_view, 3> kSizesBy{"in millimetres", "with the model", "with the view"};
constexpr std::array kHands{
    percent<StudioState, &StudioState::penCurve>(
        "penCurve", "Pen pressure", "Of all tools. Below zero a light touch does much already; above, little.", -100,
        100, 0),
    engine::Parameter<StudioState>{
        .id = "sizeBy",
        .name = "Tool sizes",
        .help = "Stay as they are, go with the size of the model that is opened, or stay as large in the window.",
        .unit = "",
        .low = 0,
        .high = 2,
        .standard = 1,
        .get = [](const StudioState& s) { return double(s.sizeBy); },
        .set = [](StudioState& s, double v) { s.sizeBy = SizeBy(int(v)); },
        .choices = kSizesBy,
    },
};

constexpr std::array kUndo{
    plain<StudioState, &StudioState::undoGiB>(
        "undoMemory", "Undo memory", "Older steps go to the disk and come back when you return to them; 0: no limit.",
        "GiB", 0, 64, 2),
};

}  // namespace

std::span<const Row<render::Look>> lookRows() {
  return kLook;
}
std::span<const Row<render::Stereo>> stereoRows() {
  return kStereo;
}
std::span<const Row<render::Quality>> qualityRows() {
  return kQuality;
}
std::span<const Row<StudioState>> pictureRows() {
  return kPicture;
}
std::span<const engine::Parameter<engine::Quality>> strokeQualityRows() {
  static const auto rows = axesOf(engine::QualityPart::strokes);
  return rows;
}
std::span<const engine::Parameter<engine::Quality>> touchQualityRows() {
  static const auto rows = axesOf(engine::QualityPart::touch);
  return rows;
}
std::span<const Row<haptics::Workspace>> workspaceRows() {
  return kWorkspace;
}
std::span<const Row<haptics::PanWalls>> wallRows() {
  return kWalls;
}
std::span<const engine::Parameter<haptics::Material>> materialRows() {
  return kMaterial;
}
std::span<const engine::Parameter<engine::Guide>> wellRows() {
  return kWell;
}
std::span<const engine::Parameter<engine::Guide>> sizeRows(Guide::Kind kind) {
  switch (engine::rowOf(kind).size) {
    case engine::GuideSize::none:
      return {};
    case engine::GuideSize::widthAndDepth:
      return std::span(kEdges).first(2);
    case engine::GuideSize::length:
      return kLength;
    case engine::GuideSize::edges:
      return kEdges;
  }
  return {};
}
std::span<const engine::Parameter<engine::Symmetry>> symmetryRows() {
  return kSymmetry;
}
bool counts(const engine::Parameter<engine::Tool>& parameter, const engine::Tool& tool, bool pointer) {
  if (engine::rowOf(tool).work != haptics::Work::cut) return true;
  static constexpr std::array<string_view, 5> kOfTheTip{"least_wall", "tip", "breadth", "thickness", "round"};
  if (std::find(kOfTheTip.begin(), kOfTheTip.end(), parameter.id) != kOfTheTip.end()) return !tool.soft || !pointer;
  if (parameter.id == "soft") return pointer;
  return parameter.id != "depth" || (tool.soft && pointer);
}
std::span<const engine::Parameter<StudioState>> handRows() {
  return kHand;
}
std::span<const engine::Parameter<StudioState>> handsRows() {
  return kHands;
}
std::span<const engine::Parameter<StudioState>> undoRows() {
  return kUndo;
}

}  // namespace argil::studio
