#include "engine/document/quality.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <set>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "engine/document/cost.h"
#include "engine/models/prepare_clay.h"
#include "engine/saving/session.h"
#include "engine/session/run.h"
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

double insideVoxels(const clay::Version& version) {
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
  EXPECT_THAT(complaint("passes=17"), HasSubstr("passes takes 0 to 16"));
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
                            R"({"quality": {"passes": 17}})", R"({"quality": 3})"})
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
  const double before = insideVoxels(ball());
  for (const char* id : {"inflate", "smooth", "scrape", "tug", "crease"}) {
    Tool tool = toolOf(id);
    const double usual = insideVoxels(stroke(tool)) - before;
    for (const double spacing : {0.05, 0.2, 0.4}) {
      tool.quality.spacing = spacing;
      tool.quality.minSpacingVoxels = 0.05;
      const double ratio = (insideVoxels(stroke(tool)) - before) / usual;
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

// What a script says of touch is what its hand feels with.
TEST(Quality, OfTouchReachesTheHand) {
  struct Felt {
    uint64_t ticks, hash;
  };
  const auto felt = [](const char* quality) {
    Script script = parseScript(R"({"argil": 1, "units": "mm",
      "setup": [{"voxel_mm": 0.5}, {"sphere": {"radius_mm": 12}}, {"quality": )" +
                                    std::string(quality) + R"(}],
      "strokes": [{"tool": "smooth", "radius_mm": 2, "drive": "hand",
                   "path": [[0, -6, 0, 14], [0.1, 0, 1, 11], [0.3, 6, 0, 13]]}]})",
                                "hand.json");
    Session session(prepareClay(clay::Store::make(script.bits()), script).document);
    clay::Surface surface(false);
    const RunReport report = runScript(session, surface, script);
    return Felt{report.servo.value().ticks, session.version().hash()};
  };
  const Felt usual = felt("{}"), fast = felt(R"({"servo_hz": 2000})"),
             rough = felt(R"({"contact_steps": 1, "contact_searches": 4, "smooth_normals": false})");
  EXPECT_NEAR(double(fast.ticks) / double(usual.ticks), 2, 0.1);
  EXPECT_EQ(rough.ticks, usual.ticks);
  EXPECT_NE(rough.hash, usual.hash);
}

// A recording begins on clay of its band.
TEST(Quality, ARecordingKnowsTheBand) {
  for (const float band : {3.0f, 5.0f}) {
    clay::Grid grid;
    grid.voxelMm = 0.5;
    grid.band = band;
    Session session(clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), 8));
    session.record();
    session.beginStroke(toolOf("carve"));
    session.addPoint(0, Vec3d(8, 0, 0));
    (void)session.endStroke();
    Script script = session.recording();
    EXPECT_EQ(script.quality.value_or(Quality()).clay.band, double(band));
    script = parseScript(formatScript(script), "recorded.json");
    script.clay = SphereSetup{.radiusMm = 8, .centreMm = Vec3d::Zero()};
    Session again(prepareClay(clay::Store::make(script.bits()), script).document);
    clay::Surface surface(false);
    (void)runScript(again, surface, script);
    EXPECT_EQ(again.version().hash(), session.version().hash()) << band;
  }
}

// A finer voxel costs more of everything, and so does a wider band.
TEST(Costs, FollowVoxelBandAndPrecision) {
  const MachineSpeed machine;
  const ClayPlan plan{.areaMm2 = 1000, .voxelMm = 0.5};
  const ClayCost cost = costOf(plan, machine);
  EXPECT_EQ(cost.activeVoxels, 2 * 3 * 1000 / 0.25);
  ClayPlan finer = plan, wider = plan, half = plan;
  finer.voxelMm = 0.25;
  wider.band = 6;
  half.precision = clay::Precision::fixed16;
  EXPECT_NEAR(costOf(finer, machine).bytes / cost.bytes, 4, 1e-9);
  EXPECT_NEAR(costOf(finer, machine).triangles / cost.triangles, 4, 1e-9);
  EXPECT_GT(costOf(finer, machine).dabMs, cost.dabMs);
  EXPECT_LT(costOf(finer, machine).edgeMm, cost.edgeMm);
  EXPECT_GT(costOf(wider, machine).bytes, cost.bytes);
  EXPECT_LT(costOf(half, machine).bytes, 0.85 * cost.bytes);
  EXPECT_THAT(sentence(plan, cost), HasSubstr("0.5 mm: 24 k voxels"));
}

// What is said before is what it is.
TEST(Costs, AreWhatClayIs) {
  for (const double band : {2.0, 3.0, 5.0})
    for (const bool block : {false, true})
      for (const auto precision : {clay::Precision::float32, clay::Precision::fixed16}) {
        clay::Grid grid;
        grid.voxelMm = 0.2;
        grid.band = static_cast<float>(band);
        const auto store = clay::Store::make(precision);
        const clay::Version clay = block ? clay::makeBlock(store, grid, Vec3d(0.03, 0.05, 0), Vec3d(30, 22, 26), 0.5)
                                         : clay::makeSphere(store, grid, Vec3d(0.03, 0.05, 0), 14);
        clay::Surface surface(true, clay::Grade::crisp);
        surface.update(clay);
        ClayPlan plan;
        plan.areaMm2 = block ? 2 * (30 * 22 + 22 * 26 + 26 * 30) : 4 * M_PI * 14 * 14;
        plan.voxelMm = grid.voxelMm;
        plan.band = band;
        plan.slant = block ? 1 : 1.5;
        plan.precision = precision;
        const ClayCost cost = costOf(plan, {});
        EXPECT_NEAR(cost.activeVoxels / double(clay.activeVoxels()), 1, 0.15) << band << block;
        EXPECT_NEAR(cost.triangles / (2 * double(surface.quadCount())), 1, 0.15) << band << block;
        EXPECT_NEAR(cost.bytes / double(clay.stats().bytes() + surface.usage().bytes), 1, 0.25) << band << block;
      }
}

TEST(Costs, AMachineGetsWhatItCanDo) {
  MachineSpeed slow, fast;
  slow.dabUs = {400, 20, 8};
  fast.dabUs = {20, 1, 0.2};
  const auto across = [](const MachineSpeed& speed, std::optional<uint64_t> memory) {
    return machineQuality(speed, memory).clay.voxelsAcross;
  };
  EXPECT_LT(across(slow, std::nullopt), across(fast, std::nullopt));
  EXPECT_LT(across(fast, uint64_t{1} << 30), across(fast, uint64_t{64} << 30));
  EXPECT_EQ(across(slow, 0), 50);
  EXPECT_LE(slow.dabMs(across(slow, std::nullopt) / 16, 3, 1.5), kMostDabMs);
  EXPECT_EQ(machineQuality(fast, {}).strokes, findQualityPreset("balanced")->quality.strokes);
}

// A busy machine spoils what it measures: the parabola through three such times may be below zero between them.
TEST(Costs, ADabNeverTakesLessThanNoTime) {
  for (const std::array<double, 3> us :
       {std::array{5.0, -40.0, 8.0}, {60.0, -20.0, 1.0}, {90.0, -12.0, 0.2}, {-30.0, 5.0, 1.0}, {40.0, 1.0, -0.02}}) {
    MachineSpeed spoilt;
    spoilt.dabUs = us;
    EXPECT_FALSE(spoilt.plausible()) << us[0];
    for (double radius = 0.5; radius < 200; radius *= 1.07)
      EXPECT_GT(spoilt.dabMs(radius, 3, 1), 0) << us[0] << " at " << radius;
  }
  MachineSpeed dips;  // and stays well above zero
  dips.dabUs = {120, -3, 0.8};
  EXPECT_TRUE(dips.plausible());
}

// The file of another machine, of another day, or of nobody.
TEST(Costs, AMachineIsMeasuredOnce) {
  const std::filesystem::path folder = std::filesystem::path(::testing::TempDir()) / "argil_machine";
  std::filesystem::remove_all(folder);
  const std::filesystem::path file = folder / "cache" / "machine.json";
  EXPECT_FALSE(readMachine(file));
  MachineSpeed speed;
  speed.dabUs = {100, 3, 0.5};
  keepMachine(file, speed);
  ASSERT_TRUE(readMachine(file));
  EXPECT_EQ(readMachine(file)->dabUs, speed.dabUs);
  for (const char* text : {"", "{", "[]", "{\"format\": 1}", "{\"format\": \"x\"}", "{\"dab_us\": 3}"}) {
    std::ofstream(file) << text;
    EXPECT_FALSE(readMachine(file)) << text;
  }
  speed.dabUs = {-100, 0, 0};
  keepMachine(file, speed);
  EXPECT_FALSE(readMachine(file));
  keepMachine("/proc/argil/machine.json", speed);  // cannot be written: no matter
  const MachineSpeed now = measureMachine();
  EXPECT_GT(now.dabMs(5, 3, 1.5), 0);
  EXPECT_GT(now.dabMs(50, 3, 1.5), now.dabMs(5, 3, 1.5));
  std::filesystem::remove_all(folder);
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
