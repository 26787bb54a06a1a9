// Files and whole pieces by plugins: what comes is checked, what fails changes nothing.

#include "engine/plugins/plugin_work.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <atomic>
#include <cstdlib>
#include <fstream>
#include <random>
#include <thread>

#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "engine/models/model_files.h"
#include "engine/plugins/plugins.h"
#include "engine/saving/saved_document.h"
#include "engine/text/script.h"
#include "engine/tools/piece_jobs.h"
#include "engine/tools/tool_table.h"
#include "io/bytes/input.h"
#include "tests/unit/engine/saving_rig.h"

namespace argil::engine {
namespace {

using testing::HasSubstr;

std::string slurped(const fs::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {(std::istreambuf_iterator<char>(in)), {}};
}

// The library of tests/support/plugins/files.c and two examples, enabled once for all tests.
class PluginWork : public SavingRig {
 protected:
  static void SetUpTestSuite() {
    const fs::path root = fs::temp_directory_path() / "work-plugins", made = root / "files.argil-plugin";
    fs::create_directories(made / kPluginMachine);
    fs::copy_file(fs::path(ARGIL_BAD_PLUGINS) / "files.so", made / kPluginMachine / "files.so");
    std::ofstream(made / kPluginFile) << R"({"format": 1, "id": "test.files", "name": "Files", "version": "1.0.0",
      "licence": "CC0-1.0", "help": "For tests.", "library": "files.so",
      "formats": [{"id": "tri", "name": "Triangles", "ending": ".tri", "reads": true, "writes": true, "unit_mm": 1}],
      "operations": [{"id": "operate", "name": "Operate", "help": "As its number says.", "doing": "Operating",
                      "numbers": [{"id": "how", "name": "How", "help": "What goes wrong.", "low": 0, "high": 9,
                                   "standard": 0}]}]})";
    Plugins plugins({root, fs::path(ARGIL_PLUGINS)}, root / "settings.json");
    for (const char* id : {"test.files", "org.argil.obj-sequence", "org.argil.roughen", "org.argil.pebbles"})
      plugins.enable(id);
    plugins.load();
    for (const FoundPlugin& each : plugins.found()) EXPECT_EQ(each.problem, "");
  }
  static Document balls() {
    Document document;
    for (const double radius : {6.0, 3.0}) {
      Piece piece;
      piece.name = radius > 4 ? "Large" : "Small";
      piece.version = ball(radius);
      piece.pose.translation = Vec3d(radius * 3, 0, 0);
      document.add(piece);
    }
    return document;
  }
  // With processes of its own, as three faults end those of a plugin.
  static std::shared_ptr<PluginProcesses> processes() {
    const fs::path made = fs::temp_directory_path() / "work-plugins" / "files.argil-plugin";
    return std::make_shared<PluginProcesses>(libraryOf(readPlugin(made), made, {}), PluginLimits{.workS = 0.5});
  }
  static io::ModelFile import(const std::string& text, Job* job = nullptr, uint64_t most = uint64_t{4} << 30) {
    return importByPlugin(*processes(), "test.files.tri", std::as_bytes(std::span(text)), job, most);
  }
  static clay::Version operate(const clay::Version& version, float how, Job* job = nullptr) {
    return operateByPlugin(*processes(), "test.files.operate", {"how"}, std::array{how}, version, job);
  }
};

TEST_F(PluginWork, WhatIsWrittenIsReadAgain) {
  const Document document = balls();
  const fs::path file = folder / "balls.tri";
  const std::vector<io::ModelObject> out = modelOf(document, {});
  const io::WriteReport report = io::writeModel(file, {out});
  EXPECT_EQ(report.format, "Triangles");
  EXPECT_EQ(report.bytes, fs::file_size(file));
  EXPECT_TRUE(slurped(file).ends_with("end\n"));
  const io::ModelFile in = io::readModel(file);
  ASSERT_EQ(in.objects.size(), 2u);
  EXPECT_EQ(in.unitMm, 1);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(in.objects[i].name, out[i].name);
    EXPECT_EQ(in.objects[i].mesh.positions, out[i].mesh.positions);
    EXPECT_EQ(in.objects[i].mesh.triangles, out[i].mesh.triangles);
  }
  // And by the doors that users have.
  const ImportedModel imported = importModel(file, {});
  EXPECT_EQ(imported.pieces.size(), 2u);
  EXPECT_THAT(io::readableEndings(), HasSubstr(".tri"));
  EXPECT_THAT(io::writableEndings(), HasSubstr(".tri"));
}

TEST_F(PluginWork, AnExportThatFailsLeavesNothing) {
  for (const auto& [name, what] : {std::pair{"crash", "Files crashed"}, {"fail", "it does not like the name"}}) {
    Document document = balls();
    document.pieces[1].name = name;
    const fs::path file = folder / "bad.tri";
    std::ofstream(file) << "as before";
    const std::vector<io::ModelObject> out = modelOf(document, {});
    const std::shared_ptr<PluginProcesses> own = processes();
    try {
      io::AtomicFile atomic(file);
      exportByPlugin(*own, "test.files.tri", atomic, {out}, {}, nullptr);
      FAIL();
    } catch (const PluginError& error) {
      EXPECT_THAT(error.what(), HasSubstr(what));
    }
    EXPECT_EQ(slurped(file), "as before");
    EXPECT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 1) << "no file beside it";
  }
}

TEST_F(PluginWork, WhatAnImporterGivesIsChecked) {
  const std::vector<std::pair<const char*, const char*>> all{
      {"!crash", "Files crashed"},
      {"!busy", "stopped"},
      {"!stuck", "did not answer for 0.5 s"},
      {"!nothing", "holds no triangles"},
      {"!huge", "without triangles, or with too many"},
      {"!orphans", "vertices of no object"},
      {"!nan", "not finite"},
      {"!few", "of another size than it said"},
      {"!many", "more vertices than it said"},
      {"!range", "whose corner is not there"},
      {"what is this", "has a line that it does not know"},
  };
  for (const auto& [text, what] : all) {
    SCOPED_TRACE(text);
    if (std::string_view(text) == "!busy") continue;  // ends by the user's hand alone: below
    try {
      (void)import(text);
      FAIL();
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr(what));
    }
  }
  std::string many = "o a 3 1\nv 0 0 0\nv 1 0 0\nv 0 1 0\nt 0 1 2\n";
  EXPECT_EQ(import(many).objects.size(), 1u);
  EXPECT_THROW((void)import(many, nullptr, 100), PluginError) << "more than memory has room for";
}

TEST_F(PluginWork, AFileThatCannotBeReadIsNamed) {
  const fs::path file = folder / "odd.tri";
  std::ofstream(file) << "what is this\n";
  try {
    (void)io::readModel(file);
    FAIL();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("odd.tri"));
    EXPECT_THAT(error.what(), HasSubstr("has a line that it does not know"));
  }
}

// One that heeds it ends by itself, one that does not is stopped; both soon.
TEST_F(PluginWork, IsCancelledInAMoment) {
  for (const char* text : {"!hang", "!stuck", "!busy"}) {
    SCOPED_TRACE(text);
    Job job;
    std::thread canceller([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      job.cancel();
    });
    const auto began = std::chrono::steady_clock::now();
    EXPECT_THROW((void)import(text, &job), Cancelled);
    EXPECT_LT(std::chrono::steady_clock::now() - began, std::chrono::seconds(3));
    canceller.join();
  }
  for (const float how : {3.0f, 4.0f}) {
    Job job;
    std::thread canceller([&] {
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
      job.cancel();
    });
    const clay::Version version = ball();
    EXPECT_THROW((void)operate(version, how, &job), Cancelled);
    canceller.join();
  }
}

// On a machine that is busy, one that naps is found ready to run more often than not.
TEST_F(PluginWork, OneThatNapsIsStoppedOnABusyMachineToo) {
  std::atomic<bool> over = false;
  std::vector<std::jthread> busy;
  for (unsigned i = 0; i < 4 * std::max(1u, std::thread::hardware_concurrency()); ++i)
    busy.emplace_back([&] {
      while (!over.load(std::memory_order_relaxed)) {
      }
    });
  const auto began = std::chrono::steady_clock::now();
  EXPECT_THROW((void)import("!stuck"), PluginError);
  const auto took = std::chrono::steady_clock::now() - began;
  over = true;
  EXPECT_LT(took, std::chrono::seconds(20));
}

// Whatever goes wrong with it in whatever work at whatever moment: the file is as before, the clay too, and it is
// named.
TEST_F(PluginWork, AnyFaultAtAnyTime) {
  const char* const asked = std::getenv("ARGIL_FAULTS");
  const int rounds = asked != nullptr ? std::atoi(asked) : 120;
  const clay::Version version = ball();
  const uint64_t before = version.hash(), after = operate(version, 0).hash();
  const std::vector<io::ModelObject> out = modelOf(balls(), {});
  const fs::path file = folder / "kept.tri";
  std::ofstream(file) << "as before";
  const io::ModelFile whole = [&] {
    io::AtomicFile atomic(folder / "whole.tri");
    exportByPlugin(*processes(), "test.files.tri", atomic, {out}, {}, nullptr);
    atomic.commit();
    return import(slurped(folder / "whole.tri"));
  }();
  const std::string text = slurped(folder / "whole.tri");
  std::mt19937 random(7);
  int faults = 0, good = 0;
  std::shared_ptr<PluginProcesses> own = processes();
  for (int round = 0; round < rounds; ++round) {
    // Three faults end a plugin, so its processes are made anew; some have served before.
    if (random() % 2 == 0) own = processes();
    std::jthread killer;
    SCOPED_TRACE(round);
    const auto kills = [&] {
      std::unique_ptr<PluginProcess> process = own->take(1);  // the one that works next
      killer = std::jthread([pid = process->pid(), after = random() % 6000] {
        std::this_thread::sleep_for(std::chrono::microseconds(after));
        ::kill(pid, SIGKILL);
      });
      own->giveBack(std::move(process));
    };
    const bool killed = random() % 2 == 0;
    try {
      switch (random() % 3) {
        case 0: {
          constexpr std::array kBad{"!crash", "!huge", "!orphans", "!nan", "!few", "!many", "!range", "?"};
          if (killed) kills();
          const std::string bytes = killed ? text : kBad[random() % kBad.size()];
          const io::ModelFile in =
              importByPlugin(*own, "test.files.tri", std::as_bytes(std::span(bytes)), nullptr, 1 << 30);
          ASSERT_TRUE(killed) << bytes;
          ASSERT_EQ(in.objects.size(), whole.objects.size());
          for (size_t i = 0; i < in.objects.size(); ++i)
            ASSERT_EQ(in.objects[i].mesh.positions, whole.objects[i].mesh.positions);
          break;
        }
        case 1: {
          std::vector<io::ModelObject> objects = out;
          if (killed) kills();
          if (!killed) objects[random() % 2].name = random() % 2 == 0 ? "crash" : "fail";
          io::AtomicFile atomic(file);
          exportByPlugin(*own, "test.files.tri", atomic, {objects}, {}, nullptr);
          ASSERT_TRUE(killed);
          break;  // not committed
        }
        default: {
          constexpr std::array kBad{1.0f, 2.0f, 5.0f};
          if (killed) kills();
          const float how = killed ? 0.0f : kBad[random() % kBad.size()];
          ASSERT_EQ(operateByPlugin(*own, "test.files.operate", {"how"}, std::array{how}, version, nullptr).hash(),
                    after);
        }
      }
      ++good;
    } catch (const Error& error) {
      ++faults;
      ASSERT_THAT(error.what(), HasSubstr("Files"));
    }
    ASSERT_EQ(version.hash(), before);
    ASSERT_EQ(slurped(file), "as before");
    ASSERT_EQ(std::distance(fs::directory_iterator(folder), fs::directory_iterator()), 2) << "no file beside them";
  }
  std::printf("%d faults, %d killed too late\n", faults, good);
  EXPECT_GT(faults, rounds / 2);
}

TEST_F(PluginWork, AnOperationThatFailsChangesNothing) {
  const clay::Version version = ball();
  const uint64_t before = version.hash();
  EXPECT_NE(operate(version, 0).hash(), before);
  EXPECT_EQ(operate(version, 6).hash(), before) << "it only looks";
  EXPECT_THROW((void)operate(version, 1), PluginError);
  EXPECT_THROW((void)operate(version, 2), PluginError);
  EXPECT_THROW((void)operate(version, 5), Error);
  EXPECT_EQ(version.hash(), before);
}

TEST_F(PluginWork, AnOperationIsARowLikeAllOthers) {
  const PieceJob* row = findPieceJob("org.argil.roughen.roughen");
  ASSERT_NE(row, nullptr);
  ASSERT_EQ(row->parameters.size(), 2u);
  Document document = balls();
  document.active = document.pieces[0].id;
  PieceArguments arguments = standardArguments(*row, document);
  const PieceResult result = runPieceJob(*row, document, arguments);
  ASSERT_EQ(result.changed.size(), 1u);
  EXPECT_NE(result.changed[0].version.hash(), document.pieces[0].version.hash());
  clay::Surface surface(false);
  surface.update(result.changed[0].version);
  EXPECT_TRUE(clay::checkTopology(surface.toMesh()).closed());
  row->parameters[0].change(arguments, 1e9);
  EXPECT_EQ(row->parameters[0].get(arguments), 10) << "within its range";
  // In a script, by its id and its numbers.
  const Script script = parseScript(R"({"argil": 1, "units": "mm", "setup": [{"sphere": {"radius_mm": 5}}],
    "strokes": [{"operation": "org.argil.roughen.roughen", "height_mm": 0.2}]})",
                                    "x");
  EXPECT_EQ(script.operations.size(), 1u);
}

TEST_F(PluginWork, ATextureIsAnImage) {
  const auto image = [&](float how) {
    return imageByPlugin(*processes(), "test.files.ramp", {"how"}, std::array{how});
  };
  const auto ramp = image(0);
  EXPECT_EQ(ramp->width(), 256);
  EXPECT_NEAR(ramp->at(0.5f, 0.5f, 0), 0.75, 0.01) << "u to the right, v upwards";
  EXPECT_NEAR(ramp->at(-0.5f, 0.5f, 0), 0.25, 0.01);
  EXPECT_NEAR(ramp->at(0.5f, -0.5f, 0), 0.5, 0.01);
  EXPECT_EQ(image(3)->at(0, 0, 0), 1) << "within its range";
  for (const float how : {1.0f, 2.0f, 4.0f}) EXPECT_THROW((void)image(how), PluginError) << how;
}

TEST_F(PluginWork, ATextureIsATool) {
  const ToolRow* row = findTool("org.argil.pebbles.pebbles");
  ASSERT_NE(row, nullptr);
  Tool tool = standardTool(*row);
  tool.radiusMm = 3;
  tool.heightMm = 1;
  Session session(balls());
  const auto hash = [&] { return session.document()->pieces[0].version.hash(); };
  const uint64_t before = hash();
  const auto cut = [&] {
    session.beginStroke(tool);
    for (int i = 0; i < 20; ++i) session.addPoint(0.01 * i, Vec3d(-2 + 0.2 * i, 0, 6));
    session.endStroke();
  };
  cut();
  const uint64_t first = hash();
  EXPECT_NE(first, before);
  EXPECT_THAT(session.history()[0], HasSubstr("Pebbles (org.argil.pebbles 1.0.0 "));
  session.undo();
  cut();
  EXPECT_EQ(hash(), first);
  session.undo();
  tool.own[0] = 2;
  cut();
  EXPECT_NE(hash(), first) << "fewer, larger ones";
  clay::Surface surface(false);
  surface.update(session.document()->pieces[0].version);
  EXPECT_TRUE(clay::checkTopology(surface.toMesh()).closed());
  const Script script = parseScript(R"({"argil": 1, "units": "mm", "setup": [{"sphere": {"radius_mm": 5}}], "strokes": [
    {"tool": "org.argil.pebbles.pebbles", "radius_mm": 2, "count": 3, "path": [[0, 0, 0, 5], [1, 1, 0, 5]]}]})",
                                    "x");
  EXPECT_THAT(formatScript(script), HasSubstr("\"plugin\""));
}

// Each state that looks like another is a file, in order.
TEST_F(PluginWork, AHistoryBecomesASequence) {
  const fs::path file = folder / "work.argil";
  Session session(balls());
  for (uint64_t i = 0; i < 5; ++i) stroke(session, i * 3 + 1);
  session.change("a guide", [](Document& d) { d.add(Guide()); });
  SaveRequest request{session.states(), session.undoSteps(), {}, std::make_shared<DocumentRecords>(), nullptr, {},
                      newWriter()};
  (void)saveDocument(file, request);
  const std::string said = writeHistory(folder / "lapse.objs", file, {});
  EXPECT_THAT(said, HasSubstr("6 files written, lapse-0001.obj to 0006"));
  std::vector<size_t> triangles;
  for (int i = 1; i <= 6; ++i) {
    const io::ModelFile model = io::readModel(folder / ("lapse-000" + std::to_string(i) + ".obj"));
    EXPECT_EQ(model.objects.size(), 2u);
    size_t count = 0;
    for (const io::ModelObject& object : model.objects) count += object.mesh.triangles.size();
    triangles.push_back(count);
    EXPECT_THAT(slurped(folder / ("lapse-000" + std::to_string(i) + ".obj")),
                testing::StartsWith("# Frame " + std::to_string(i) + " of 6"));
  }
  EXPECT_FALSE(fs::exists(folder / "lapse-0007.obj"));
  EXPECT_EQ(std::set<size_t>(triangles.begin(), triangles.end()).size(), 6u) << "all differ";
  EXPECT_THROW((void)writeHistory(folder / "x.objs", folder / "lapse-0001.obj", {}), Error);
}

}  // namespace
}  // namespace argil::engine
