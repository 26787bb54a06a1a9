#include "engine/document/quality.h"

#include <gmock/gmock.h>

#include <cmath>
#include <set>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/models/prepare_clay.h"
#include "engine/saving/session.h"
#include "engine/text/document_text.h"
#include "engine/text/script.h"
#include "engine/tools/tool_table.h"
#include "tests/unit/engine/workbench_rig.h"

namespace argil::engine {
namespace {

using ::testing::HasSubstr;
using ::testing::Not;

constexpr double kBallMm = 12;

clay::Version ball() {
  clay::Grid grid;
  grid.voxelMm = 0.4;
  return clay::makeSphere(clay::Store::make(), grid, Vec3d(0.1, 0.05, 0), kBallMm);
}

// A tool drawn around a part of the ball.
clay::Version stroke(const Tool& tool) {
  Session session(ball());
  session.beginStroke(tool);
  for (int i = 0; i <= 30; ++i) {
    const double angle = 0.05 * i, height = 0.2 * std::sin(4 * angle);
    session.addPoint(0.01 * i, (kBallMm - 0.6) * Vec3d(std::cos(angle), std::sin(angle), height));
  }
  return session.endStroke();
}

Tool toolOf(std::string_view id) {
  Tool tool = scriptTool(*findTool(id));
  tool.radiusMm = 3;
  tool.heightMm = 1;
  tool.strength = 0.5;
  return tool;
}

double insideMm3(const clay::Version& version) {
  double voxels = 0;
  version.forEachBrick([&](const clay::Brick& brick) {
    for (int v = 0; v < clay::kBrickVoxels; ++v)
      voxels += std::clamp(0.5 - double(version.find(brick.coord).phi(v, version.grid().band)), 0.0, 1.0);
  });
  return voxels;  // tiles inside are the same before and after strokes this shallow
}

std::string complaint(const std::string& text) {
  try {
    (void)readQuality(text);
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  return "nothing was wrong";
}

TEST(Quality, AxesHaveANameEachAndBeginWithinTheirRange) {
  std::set<std::string_view> ids;
  for (const QualityAxis& axis : qualityAxes()) {
    SCOPED_TRACE(axis.row.id);
    EXPECT_TRUE(ids.insert(axis.row.id).second);
    EXPECT_EQ(axis.row.get({}), axis.row.standard);
    EXPECT_LE(axis.row.low, axis.row.standard);
    EXPECT_GE(axis.row.high, axis.row.standard);
    for (const double value : {axis.row.low, axis.row.high}) {
      Quality quality;
      axis.row.set(quality, value);
      EXPECT_EQ(axis.row.get(quality), value);
      EXPECT_NO_THROW(quality.strokes.check());
    }
    // Nobody else's number moves.
    Quality other;
    axis.row.set(other, axis.row.standard == axis.row.high ? axis.row.low : axis.row.high);
    for (const QualityAxis& beside : qualityAxes()) {
      if (&beside == &axis) continue;
      EXPECT_EQ(beside.row.get(other), beside.row.standard) << beside.row.id;
    }
  }
  EXPECT_EQ(findQualityAxis("speed"), nullptr);
}

TEST(Quality, PresetsHaveOneNameEachAndAreFoundAgain) {
  for (const QualityPreset& preset : qualityPresets()) {
    EXPECT_EQ(findQualityPreset(preset.id), &preset);
    for (const QualityPart part : {QualityPart::clay, QualityPart::strokes, QualityPart::touch, QualityPart::surface}) {
      const QualityPreset* found = presetOf(preset.quality, part);
      ASSERT_NE(found, nullptr);
      for (const QualityAxis& axis : qualityAxes()) {
        if (axis.part != part) continue;
        EXPECT_EQ(axis.row.get(found->quality), axis.row.get(preset.quality)) << axis.row.id;
      }
    }
  }
  Quality odd;
  odd.strokes.spacing = 0.123;
  EXPECT_EQ(presetOf(odd, QualityPart::strokes), nullptr);
}

TEST(Quality, IsReadFromAText) {
  EXPECT_EQ(readQuality("fine"), findQualityPreset("fine")->quality);
  Quality changed = findQualityPreset("draft")->quality;
  changed.strokes.spacing = 0.05;
  changed.surface = clay::Grade::fine;
  EXPECT_EQ(readQuality("draft,spacing=0.05,surface=fine"), changed);
  changed = findQualityPreset("balanced")->quality;
  changed.clay.band = 4;
  EXPECT_EQ(readQuality("band=4"), changed);
}

TEST(Quality, WhatIsWrongInATextIsSaidInOneLine) {
  EXPECT_THAT(complaint(""), HasSubstr("draft, balanced, fine"));
  EXPECT_THAT(complaint("best"), HasSubstr("\"best\" is no preset"));
  EXPECT_THAT(complaint("fine,draft"), HasSubstr("\"draft\" is no preset"));
  EXPECT_THAT(complaint("fine,speed=2"), HasSubstr("\"speed\" is no axis"));
  for (const char* value : {"", "x", "0.1x", "nan", "inf", "-1", "1e9"})
    EXPECT_THAT(complaint(std::string("spacing=") + value), HasSubstr("spacing takes 0.01 to 1")) << value;
  EXPECT_THAT(complaint("surface=good"), HasSubstr("surface takes draft, crisp, fine"));
  EXPECT_THAT(complaint("passes=1"), HasSubstr("passes of 1 is out of range"));
}

TEST(Quality, GoesWithScripts) {
  const std::string text = R"({"argil": 1, "units": "mm",
   "setup": [{"quality": {"preset": "balanced", "spacing": 0.3, "band": 4}}, {"sphere": {"radius_mm": 8}}],
   "strokes": [{"tool": "carve", "radius_mm": 2, "path": [[0, 8, 0, 0]]},
               {"tool": "carve", "radius_mm": 2, "quality": {"flow_step": 0.5}, "path": [[0, 8, 0, 0]]},
               {"tool": "carve", "radius_mm": 2, "quality": {}, "path": [[0, 8, 0, 0]]}]})";
  Script script = parseScript(text, "q.json");
  ASSERT_TRUE(script.quality);
  EXPECT_EQ(script.quality->clay.band, 4);
  EXPECT_EQ(script.strokes[0].tool.quality, script.quality->strokes);
  EXPECT_EQ(script.strokes[0].tool.quality.spacing, 0.3);
  EXPECT_EQ(script.strokes[1].tool.quality.spacing, StrokeQuality().spacing);
  EXPECT_EQ(script.strokes[1].tool.quality.clay.flowStep, 0.5);
  EXPECT_EQ(script.strokes[2].tool.quality, StrokeQuality());
  EXPECT_EQ(parseScript(formatScript(script), "back.json"), script);

  // Another quality reaches the strokes that have none of their own.
  script.use(findQualityPreset("fine")->quality);
  EXPECT_EQ(script.strokes[0].tool.quality, findQualityPreset("fine")->quality.strokes);
  EXPECT_EQ(script.strokes[1].tool.quality.clay.flowStep, 0.5);
  EXPECT_EQ(parseScript(formatScript(script), "back.json"), script);

  for (const char* wrong : {R"({"quality": "best"})", R"({"quality": {"spacing": 7}})", R"({"quality": {"speed": 1}})",
                            R"({"quality": {"passes": 1}})", R"({"quality": 3})"})
    EXPECT_THROW(
        (void)parseScript(R"({"argil": 1, "units": "mm", "strokes": [], "setup": [)" + std::string(wrong) + "]}", "x"),
        Error)
        << wrong;
}

TEST(Quality, SaysWhatClayAScriptBeginsWith) {
  Script script;
  script.clay = SphereSetup{.radiusMm = 8, .centreMm = Vec3d::Zero()};
  EXPECT_EQ(prepareClay(clay::Store::make(script.bits()), script).version.grid().voxelMm, 0.5);
  Quality quality;
  quality.clay = {.voxelsAcross = 80, .band = 5, .halfMemory = true};
  quality.strokes.spacing = 0.25;
  script.use(quality);
  EXPECT_EQ(script.bits(), clay::Precision::fixed16);
  PreparedClay clay = prepareClay(clay::Store::make(script.bits()), script);
  EXPECT_EQ(clay.version.grid().voxelMm, 16.0 / 80);
  EXPECT_EQ(clay.version.grid().band, 5);
  EXPECT_EQ(clay.document.quality, quality.strokes);
  script.voxelMm = 0.4;
  EXPECT_EQ(prepareClay(clay::Store::make(script.bits()), script).version.grid().voxelMm, 0.4);
}

TEST(Quality, GoesWithDocuments) {
  Document document;
  const std::string plain = documentText(document, {}, {});
  EXPECT_THAT(plain, Not(HasSubstr("quality")));
  EXPECT_EQ(readDocumentText(plain, "x").document.quality, StrokeQuality());
  document.quality.clay.tolerance = 0.05;
  document.quality.minSpacingVoxels = 2;
  std::vector<std::string> unknown;
  EXPECT_EQ(readDocumentText(documentText(document, {}, {}), "x", &unknown).document.quality, document.quality);
  EXPECT_TRUE(unknown.empty());
}

// An axis that changes nothing is a knob that nothing turns.
TEST(Quality, EveryAxisOfStrokesChangesSomeStroke) {
  const char* tools[] = {"carve", "smooth", "scrape", "tug", "inflate"};
  std::vector<uint64_t> as;
  for (const char* id : tools) as.push_back(stroke(toolOf(id)).hash());
  for (const QualityAxis& axis : qualityAxes()) {
    if (axis.part != QualityPart::strokes) continue;
    bool changed = false;
    for (const double value : {axis.row.high, axis.row.id == "passes" ? 2 : axis.row.low})
      for (size_t i = 0; i < std::size(tools) && !changed; ++i) {
        Tool tool = toolOf(tools[i]);
        Quality quality;
        axis.row.set(quality, value);
        tool.quality = quality.strokes;
        changed = stroke(tool).hash() != as[i];
      }
    EXPECT_TRUE(changed) << axis.row.id;
  }
}

// Stamps farther apart do more each: how far apart they are is no strength.
TEST(Quality, FewerStampsDoAsMuch) {
  const double before = insideMm3(ball());
  for (const char* id : {"inflate", "smooth", "scrape", "tug", "crease"}) {
    Tool tool = toolOf(id);
    const double usual = insideMm3(stroke(tool)) - before;
    for (const double spacing : {0.05, 0.2, 0.4}) {
      tool.quality.spacing = spacing;
      tool.quality.minSpacingVoxels = 0.05;
      const double ratio = (insideMm3(stroke(tool)) - before) / usual;
      EXPECT_NEAR(ratio, 1, spacing <= 0.2 ? 0.2 : 0.4) << id << " " << spacing;
    }
  }
}

TEST(Quality, IsASettingOfTheHand) {
  Session session(ball());
  StrokeQuality coarse;
  coarse.spacing = 0.4;
  session.setQuality(coarse);
  EXPECT_EQ(session.document()->quality, coarse);
  EXPECT_EQ(session.undoSteps(), 0u);
  Tool tool = toolOf("carve");
  tool.quality = coarse;
  session.beginStroke(tool);
  EXPECT_THROW(session.setQuality({}), Error);
  session.addPoint(0, Vec3d(kBallMm, 0, 0));
  (void)session.endStroke();
  EXPECT_TRUE(session.undo());
  EXPECT_EQ(session.document()->quality, coarse);
  coarse.spacing = NAN;
  EXPECT_THROW(session.setQuality(coarse), Error);
}

// What a person chose holds for strokes from then on, and comes back with the file.
TEST(Quality, TheWorkbenchWorksAndSavesWithIt) {
  const std::filesystem::path file = std::filesystem::path(::testing::TempDir()) / "argil_quality.argil";
  std::filesystem::remove(file);
  StrokeQuality coarse;
  coarse.spacing = 1;
  const auto carved = [&](const StrokeQuality& quality) -> uint64_t {
    Workbench bench(withoutJournal());
    bench.addBlock({60, 30, 20}, 2, {.voxelMm = 0.5});
    // A new document is balanced.
    EXPECT_TRUE(until([&] { return bench.snapshot()->document->pieces.size() == 1; }));
    EXPECT_EQ(bench.snapshot()->document->quality, findQualityPreset("balanced")->quality.strokes);
    bench.setQuality(quality);
    EXPECT_TRUE(until([&] { return bench.snapshot()->document->quality == quality; }));
    bench.strokeAlong({{-10, 0, 10}, {0, 8, 10}, {1, -8, 10}, {10, 0, 10}});
    EXPECT_TRUE(until([&] { return bench.snapshot()->done == 2; })) << problemsOf(bench);
    bench.saveAs(file, {});
    EXPECT_TRUE(until([&] { return !bench.snapshot()->file.unsaved; })) << problemsOf(bench);
    return bench.snapshot()->document->pieces[0].version.hash();
  };
  const uint64_t usual = carved({});
  EXPECT_NE(carved(coarse), usual);
  Workbench bench(withoutJournal());
  bench.open(file);
  ASSERT_TRUE(until([&] { return bench.snapshot()->document->pieces.size() == 1; }));
  EXPECT_EQ(bench.snapshot()->document->quality, coarse);
  std::filesystem::remove(file);
}

}  // namespace
}  // namespace argil::engine
