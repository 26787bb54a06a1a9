// Guides and materials in scripts: read, written, refused, felt.

#include "engine/text/guide_setup.h"

#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "engine/session/run.h"
#include "engine/text/script.h"
#include "haptics/scene/polyline.h"

namespace argil::engine {
namespace {

using ::testing::HasSubstr;

const char* const kGuides[] = {
    R"({"guide": "lock_to_point", "at": [1, 2, 3]})",
    R"({"guide": "lock_to_line", "at": [1, 2, 3], "direction": [0, 0, 2]})",
    R"({"guide": "lock_to_plane", "at": [1, 2, 3], "direction": [0, 1, 1], "while_buttons": 2})",
    R"({"guide": "lock_to_curve", "points": [[0, 0, 0], [1, 0, 0], [1, 1, 0]], "closed": true})",
    R"({"guide": "lock_to_normal"})",
    R"({"guide": "keep_out_box", "at": [0, 0, 5], "size_mm": [4, 5, 6], "inside": true})",
    R"({"guide": "keep_out_ball", "at": [0, 0, 5], "radius_mm": 4})",
    R"({"guide": "keep_out_plane", "at": [0, 0, 5], "direction": [0, 0, 1]})",
    R"({"guide": "well_at_points", "points": [[0, 0, 0], [9, 0, 0]], "range_mm": 3, "force_n": 0.5})",
    R"({"guide": "well_at_curve", "points": [[0, 0, 0], [9, 0, 0]], "range_mm": 3, "force_n": 0.5})",
    R"({"guide": "well_at_plane", "at": [0, 0, 0], "direction": [1, 0, 0], "range_mm": 3, "force_n": 0.5})",
    R"({"guide": "well_at_clay", "range_mm": 3, "force_n": 0.5})",
    R"({"guide": "gravity", "direction": [0, 0, -3], "force_n": 0.3})",
    R"({"guide": "buoyancy", "at": [0, 0, 0], "direction": [0, 0, 1], "force_n": 0.3, "depth_mm": 5})",
    R"({"guide": "viscosity", "drag_nsmm": 0.002})",
    R"({"guide": "ambient_plane", "at": [0, 0, 0], "direction": [0, 0, 1], "stiffness_nmm": 0.1, "force_n": 1})"};

std::string script(const std::string& setup, const std::string& strokes = "") {
  return R"({"argil": 1, "units": "mm", "setup": [)" + setup + R"(], "strokes": [)" + strokes + "]}";
}

std::string complaint(const std::string& setup) {
  try {
    (void)parseScript(script(setup), "cut.json");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    return error.what();
  }
  return "nothing was wrong";
}

TEST(GuideSetup, EveryKindIsReadWrittenAndFitForAScene) {
  std::string all;
  for (const char* guide : kGuides) all += (all.empty() ? "" : ", ") + std::string(guide);
  const Script first = parseScript(script(R"({"guides": [)" + all + "]}"), "cut.json");
  ASSERT_EQ(first.guides.size(), std::size(kGuides));
  for (size_t i = 0; i < first.guides.size(); ++i) EXPECT_EQ(static_cast<size_t>(first.guides[i].kind), i);
  EXPECT_EQ(parseScript(formatScript(first), "again.json"), first);

  const std::vector<haptics::Guide> scene = sceneGuides(first.guides);
  ASSERT_EQ(scene.size(), first.guides.size());
  const auto& plane = std::get<haptics::LockToPlane>(scene[2].shape);
  EXPECT_EQ(plane.point, Vec3d(1, 2, 3));
  EXPECT_EQ(plane.normal, Vec3d(0, 1, 1));
  EXPECT_EQ(scene[2].whileButtons, 2u);
  EXPECT_TRUE(std::get<haptics::LockToCurve>(scene[3].shape).curve->closed());
  const auto& box = std::get<haptics::KeepOutBox>(scene[5].shape);
  EXPECT_EQ(box.halfMm, Vec3d(2, 2.5, 3));
  EXPECT_TRUE(box.inside);
  EXPECT_EQ(std::get<haptics::Gravity>(scene[12].shape).forceN, Vec3d(0, 0, -0.3));
}

TEST(GuideSetup, SaysWhatIsWrong) {
  EXPECT_THAT(complaint(R"({"guides": [{"guide": "lock"}]})"),
              HasSubstr("setup[0].guides[0].guide: unknown \"lock\"; known are lock_to_point"));
  EXPECT_THAT(complaint(R"({"guides": [{"at": [0, 0, 0]}]})"), HasSubstr("\"guide\" is missing"));
  EXPECT_THAT(complaint(R"({"guides": [{"guide": "lock_to_line", "at": [0, 0, 0]}]})"),
              HasSubstr("\"direction\" is missing"));
  EXPECT_THAT(complaint(R"({"guides": [{"guide": "lock_to_line", "at": [0, 0, 0], "direction": [0, 0, 0]}]})"),
              HasSubstr("is no direction"));
  EXPECT_THAT(complaint(R"({"guides": [{"guide": "lock_to_point", "at": [0, 0, 0], "force_n": 1}]})"),
              HasSubstr("unknown key \"force_n\""));
  EXPECT_THAT(complaint(R"({"guides": [{"guide": "lock_to_curve", "points": [[0, 0, 0]]}]})"),
              HasSubstr("setup[0].guides[0].points"));
  EXPECT_THAT(complaint(R"({"guides": [{"guide": "keep_out_ball", "at": [0, 0, 0], "radius_mm": 0}]})"),
              HasSubstr("radius_mm"));
  EXPECT_THAT(complaint(R"({"guides": [{"guide": "lock_to_normal"}]}, {"guides": []})"), HasSubstr("is there twice"));
  EXPECT_THAT(complaint(R"({"material": {"static_friction": 0.1, "dynamic_friction": 0.2}})"),
              HasSubstr("no more than static_friction"));
  EXPECT_THAT(complaint(R"({"material": {"softness": 1}})"), HasSubstr("unknown key"));
  EXPECT_THAT(complaint(R"({"material": {"hardness_nmm2": -1}})"), HasSubstr("out of range"));
}

TEST(GuideSetup, MaterialsSurviveWriting) {
  const Script first = parseScript(
      script(R"({"material": {"stiffness_nmm": 0.7, "static_friction": 0.4, "dynamic_friction": 0.3}})"), "cut.json");
  EXPECT_EQ(first.material.stiffnessNmm, 0.7);
  EXPECT_EQ(first.material.hardnessNmm2, haptics::Material().hardnessNmm2);
  EXPECT_EQ(parseScript(formatScript(first), "again.json"), first);
}

TEST(GuideSetup, RowsOfMaterialsSurviveWriting) {
  const Script first = parseScript(
      script(
          R"({"materials": [{"name": "wax", "colour": "#3366cc", "material": {"stiffness_nmm": 0.7}}, {"name": "as it is"}]})"),
      "cut.json");
  ASSERT_EQ(first.materials.size(), 2u);
  EXPECT_EQ(bytesOf(first.materials[0].colour.value()), (std::array<uint8_t, 3>{0x33, 0x66, 0xcc}));
  EXPECT_EQ(first.materials[0].material.stiffnessNmm, 0.7);
  EXPECT_EQ(first.materials[1], (MaterialRow{"as it is", {}, {}}));
  EXPECT_EQ(parseScript(formatScript(first), "again.json"), first);
  EXPECT_THAT(complaint(R"({"materials": [{"colour": "#3366cc"}]})"), HasSubstr("name"));
  EXPECT_THAT(complaint(R"({"materials": [{"name": "wax", "colour": "blue"}]})"), HasSubstr("colour"));
  EXPECT_THAT(complaint(R"({"materials": [{"name": "wax", "shine": 1}]})"), HasSubstr("unknown key"));
}

// The hand wobbles up and down by millimetres; the plane holds the cut flat.
TEST(GuideSetup, APlaneHoldsTheCutOfAHandThatWobbles) {
  const auto cut = [](const std::string& guides) {
    std::string path;
    for (int i = 0; i <= 60; ++i) {
      path += (i ? ", " : "") +
              fmt::format("[{}, {}, 0, {}]", 0.04 * i, -12 + 0.4 * i, 11.5 + (i > 5 ? 1.2 * std::sin(0.6 * i) : 0));
    }
    const Script whole =
        parseScript(script(R"({"block": {"size_mm": [40, 20, 20]}})" + guides,
                           R"({"tool": "carve", "radius_mm": 2, "drive": "hand", "path": [)" + path + "]}"),
                    "cut.json");
    clay::Grid grid;
    grid.voxelMm = 0.5;
    Session session(clay::makeBlock(clay::Store::make(), grid, Vec3d::Zero(), {40, 20, 20}, 0));
    clay::Surface surface;
    runScript(session, surface, whole);
    double low = 1e9, high = -1e9;
    const Script recorded = session.recording();
    EXPECT_FALSE(recorded.strokes.empty());
    for (const ScriptStroke& stroke : recorded.strokes)
      for (const PathPoint& point : stroke.path) {
        low = std::min(low, point.mm.z());
        high = std::max(high, point.mm.z());
      }
    return std::pair(low, high);
  };
  const auto [low, high] =
      cut(R"(, {"guides": [{"guide": "lock_to_plane", "at": [0, 0, 11.5], "direction": [0, 0, 1]}]})");
  EXPECT_NEAR(low, 11.5, 1e-3);
  EXPECT_NEAR(high, 11.5, 1e-3);
  const auto [freeLow, freeHigh] = cut("");
  EXPECT_GT(freeHigh - freeLow, 0.5);
}

}  // namespace
}  // namespace argil::engine
