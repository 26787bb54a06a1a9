// Strokes of plugins' brushes in a document: steps like all others, in the journal as clay, and a fault ends the
// stroke.

#include <gmock/gmock.h>

#include <nlohmann/json.hpp>

#include "clay/base/error.h"
#include "engine/models/prepare_clay.h"
#include "engine/session/recovery.h"
#include "engine/session/run.h"
#include "engine/text/script.h"
#include "tests/support/plugins/loaded_plugins.h"
#include "tests/unit/engine/saving_rig.h"
#include "tests/unit/engine/workbench_rig.h"

namespace argil::engine {
namespace {

using testing::HasSubstr;

Tool strips() {
  Tool tool = tests::pluginTool(tests::examplePlugin("clay-strips"));
  tool.radiusMm = 4;
  return tool;
}

class PluginStroke : public SavingRig {
 protected:
  static Document oneBall() {
    Document document;
    Piece piece;
    piece.version = ball();
    document.add(piece);
    return document;
  }
  // Over the top of the ball, from `from` to `to` of 40 points.
  static void points(Session& session, int from, int to) {
    for (int i = from; i < to; ++i) session.addPoint(0.01 * i, Vec3d(-4 + 0.2 * i, 0, 12));
  }
  static uint64_t clayOf(const Document& document) { return document.pieces[0].version.hash(); }

  fs::path badFolder() { return folder / "bad"; }
};

TEST_F(PluginStroke, IsOneStepThatSaysWhatMadeIt) {
  Session session(oneBall());
  const uint64_t before = clayOf(*session.document());
  session.beginStroke(strips());
  points(session, 0, 40);
  (void)session.publish();
  session.endStroke();
  const uint64_t after = clayOf(*session.document());
  EXPECT_NE(after, before);
  ASSERT_EQ(session.undoSteps(), 1u);
  EXPECT_THAT(session.history()[0], HasSubstr("Clay strips (org.argil.clay-strips 1.0.0 "));
  session.undo();
  EXPECT_EQ(clayOf(*session.document()), before);
  session.redo();
  EXPECT_EQ(clayOf(*session.document()), after);
}

// The journal of a program that ends in mid-stroke has the clay that was published last, and a recovery repeats
// nothing.
TEST_F(PluginStroke, IsInTheJournalAsClay) {
  const fs::path journals = folder / "journals", left = folder / "left.journal";
  Kept kept(oneBall(), journals);
  kept.folder = journals;
  stroke(kept.session, 0);
  kept.session.beginStroke(strips());
  std::vector<uint64_t> published;
  for (int i = 0; i < 40; i += 2) {
    points(kept.session, i, i + 2);
    (void)kept.session.publish();
    published.push_back(clayOf(*kept.session.document()));
    if (i == 20) std::this_thread::sleep_for(std::chrono::milliseconds(60));  // told at most each 50 ms
  }
  std::this_thread::sleep_for(std::chrono::milliseconds(60));
  (void)kept.session.publish();
  points(kept.session, 40, 41);
  (void)kept.session.publish();
  published.push_back(clayOf(*kept.session.document()));
  Recovered recovered = recover(kept.crash(left));
  EXPECT_TRUE(recovered.strokes.empty()) << "nothing has to be computed by the plugin again";
  const DocumentPtr document = recovered.document.states[recovered.document.done].document;
  EXPECT_EQ(clayOf(*document), published.back());
  EXPECT_EQ(recovered.document.done, 2u) << "the stroke is one step";
  EXPECT_THAT(recovered.document.states[2].label, HasSubstr("org.argil.clay-strips 1.0.0"));
  // And when it has ended, the last of it.
  kept.session.endStroke();
  const uint64_t last = clayOf(*kept.session.document());
  kept.session.undo();
  kept.session.redo();
  recovered = recover(kept.crash(folder / "later.journal"));
  EXPECT_EQ(recovered.document.done, 2u);
  EXPECT_EQ(clayOf(*recovered.document.states[2].document), last);
  EXPECT_EQ(kept.trouble, "");
}

// A stroke that failed leaves the clay as before the stamp, as a step that can be undone.
TEST_F(PluginStroke, EndsWhereItsPluginFailed) {
  for (const char* name : {"crash", "nan", "fails"}) {
    SCOPED_TRACE(name);
    const fs::path journals = folder / name, left = folder / (std::string(name) + ".journal");
    Kept kept(oneBall(), journals);
    kept.folder = journals;
    Session& session = kept.session;
    const uint64_t before = clayOf(*session.document());
    session.beginStroke(tests::pluginTool(tests::badPlugin(badFolder(), name)));
    EXPECT_THROW(points(session, 0, 40), PluginError);
    (void)session.publish();
    session.endStroke();
    EXPECT_FALSE(session.inStroke());
    const uint64_t after = clayOf(*session.document());
    EXPECT_NE(after, before) << "two stamps were whole";
    EXPECT_EQ(session.undoSteps(), 1u);
    const Recovered recovered = recover(kept.crash(left));
    EXPECT_EQ(clayOf(*recovered.document.states[recovered.document.done].document), after);
    session.undo();
    EXPECT_EQ(clayOf(*session.document()), before);
    // Others go on.
    stroke(session, 1);
    EXPECT_NE(clayOf(*session.document()), before);
  }
}

TEST_F(PluginStroke, ThatCannotBeginChangesNothing) {
  Session session(oneBall());
  const uint64_t before = clayOf(*session.document());
  session.beginStroke(tests::pluginTool(tests::badPlugin(badFolder(), "init_fails")));
  EXPECT_THROW(points(session, 0, 3), PluginError);
  session.endStroke();
  EXPECT_EQ(clayOf(*session.document()), before);
  EXPECT_EQ(session.undoSteps(), 0u);
}

// What the journal was told of stays a step, so that both count alike.
TEST_F(PluginStroke, ThatIsAbandonedLeavesJournalAndHistoryAlike) {
  const fs::path journals = folder / "journals", left = folder / "left.journal";
  Kept kept(oneBall(), journals);
  kept.folder = journals;
  const uint64_t before = clayOf(*kept.session.document());
  stroke(kept.session, 0);
  kept.session.undo();
  kept.session.beginStroke(strips());
  points(kept.session, 0, 40);
  (void)kept.session.publish();
  kept.session.abandonStroke();
  EXPECT_EQ(clayOf(*kept.session.document()), before);
  for (int i = 0; i < 3; ++i) stroke(kept.session, 10 + static_cast<uint64_t>(i));
  kept.session.undo();
  const Recovered recovered = recover(kept.crash(left));
  EXPECT_EQ(recovered.document.done, kept.session.undoSteps());
  EXPECT_EQ(clayOf(*recovered.document.states[recovered.document.done].document), clayOf(*kept.session.document()));
}

TEST_F(PluginStroke, InAScriptNamesItsPlugin) {
  (void)strips();
  const std::string setup = R"({"argil": 1, "units": "mm", "setup": [{"sphere": {"radius_mm": 12}}],)";
  const std::string stroke =
      R"("strokes": [{"tool": "org.argil.clay-strips.clay-strips", "radius_mm": 4, "strips": 5,
         "path": [[0, -4, 0, 12], [1, 4, 0, 12]]}]})";
  const Script script = parseScript(setup + stroke, "x");
  EXPECT_EQ(script.strokes.at(0).tool.own[0], 5);
  const std::string text = formatScript(script);
  EXPECT_THAT(text, HasSubstr("\"plugin\""));
  EXPECT_THAT(text, HasSubstr("\"org.argil.clay-strips\""));
  EXPECT_EQ(parseScript(text, "back"), script);
  // Another version's.
  std::string other = text;
  const size_t at = other.find(rowOf(script.strokes[0].tool).origin->checksum);
  ASSERT_NE(at, std::string::npos);
  other[at] = other[at] == 'a' ? 'b' : 'a';
  try {
    (void)parseScript(other, "other.json");
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("needs \"org.argil.clay-strips\" \"1.0.0\", and 1.0.0 is enabled"));
  }
}

// A hand in virtual time feels the clay that a plugin's brush makes, the same each time.
TEST_F(PluginStroke, IsFeltByAHandAndRepeats) {
  (void)strips();
  const Script script = parseScript(R"({"argil": 1, "units": "mm",
    "setup": [{"voxel_mm": 0.5}, {"sphere": {"radius_mm": 12}}],
    "strokes": [{"tool": "org.argil.clay-strips.clay-strips", "radius_mm": 3, "drive": "hand",
                 "path": [[0, -5, 0, 18], [0.3, -5, 0, 10], [0.8, 5, 0, 10], [1, 5, 0, 18]]}]})",
                                    "x");
  struct Ran {
    explicit Ran(const Script& what)
        : session(prepareClay(clay::Store::make(), what).version), before(clayOf(*session.document())) {
      report = runScript(session, surface, what);
    }
    Session session;
    uint64_t before;
    clay::Surface surface;
    RunReport report;
  };
  const Ran first(script), second(script);
  EXPECT_NE(clayOf(*first.session.document()), first.before);
  EXPECT_EQ(clayOf(*first.session.document()), clayOf(*second.session.document()));
  ASSERT_TRUE(first.report.servo);
  EXPECT_GT(first.report.servo->touching, 0u);
  EXPECT_GT(first.report.servo->peakForceN, 0.05);
}

// In the studio's workbench: a sentence, and the next stroke works.
TEST_F(WorkbenchTest, APluginThatCrashesEndsTheStrokeWithASentence) {
  const fs::path made = tests::badPlugin(fs::temp_directory_path() / "bench-bad", "kill");
  block();
  (void)problems();
  Tool tool = tests::pluginTool(made);
  tool.radiusMm = 4;
  bench.setTool(tool);
  drag(1);
  ASSERT_TRUE(rest());
  ASSERT_TRUE(until([&] { return problems().find("Bad kill crashed (Killed)") != std::string::npos; }));
  const uint64_t after = document()->pieces[0].version.hash();
  Tool carve;
  carve.radiusMm = 4;
  bench.setTool(carve);
  drag(1);
  ASSERT_TRUE(until([&] { return bench.idle() && document()->pieces[0].version.hash() != after; }));
  EXPECT_EQ(problems(), "");
}

}  // namespace
}  // namespace argil::engine
