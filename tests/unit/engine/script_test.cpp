#include "engine/text/script.h"
#include "engine/models/script_file.h"

#include <gmock/gmock.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "clay/base/error.h"
#include "engine/text/operation_text.h"
#include "engine/text/parameter_text.h"

namespace argil::engine {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;

const char* const kWhole = R"({"argil": 1, "units": "mm",
  "setup": [{"voxel_mm": 0.25}, {"block": {"size_mm": [60, 40, 20], "round_mm": 2}}, {"fit_mm": 90}],
  "strokes": [
    {"tool": "carve", "radius_mm": 3, "path": [[0, 1, 2, 3], [0.5, 4, 5, 6.25]]},
    {"tool": "smooth", "radius_mm": 8, "strength": 0.3, "drive": "hand", "path": [[0, -1e1, 0, 0]]}
  ]})";

std::string complaint(const std::string& text) {
  try {
    (void)parseScript(text, "cut.json");
  } catch (const Error& error) {
    EXPECT_EQ(error.kind(), Error::Kind::input);
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    return error.what();
  }
  return "nothing was wrong";
}

std::string withStroke(const std::string& stroke) {
  return R"({"argil": 1, "units": "mm", "strokes": [{"tool": "add", "radius_mm": 1, "path": [[0,0,0,0]]}, )" + stroke +
         "]}";
}

std::string withSetup(const std::string& setup) {
  return R"({"argil": 1, "units": "mm", "strokes": [], "setup": [)" + setup + "]}";
}

TEST(Script, ReadsEveryPart) {
  const Script script = parseScript(kWhole, "cut.json");
  EXPECT_EQ(script.voxelMm, 0.25);
  EXPECT_EQ(script.fitMm, 90);
  EXPECT_EQ(std::get<BlockSetup>(script.clay), (BlockSetup{Vec3d(60, 40, 20), 2, Vec3d::Zero()}));
  ASSERT_EQ(script.strokes.size(), 2u);
  EXPECT_EQ(script.strokes[0].tool, (Tool{"carve", 3, 1}));
  EXPECT_EQ(script.strokes[0].drive, Drive::tip);
  ASSERT_EQ(script.strokes[0].path.size(), 2u);
  EXPECT_EQ(script.strokes[0].path[1], (PathPoint{0.5, Vec3d(4, 5, 6.25)}));
  EXPECT_EQ(script.strokes[1].tool, (Tool{"smooth", 8, 0.3}));
  EXPECT_EQ(script.strokes[1].drive, Drive::hand);
  EXPECT_EQ(std::get<SphereSetup>(parseScript(withSetup(R"({"sphere": {"radius_mm": 7}})"), "x").clay).radiusMm, 7);
}

TEST(Script, NamesThePlaceAndTheFault) {
  const std::pair<std::string, std::string> faults[] = {
      {"", "cut.json: line 1, column 1: not JSON"},
      {"{\"argil\": 1,\n  \"units\" \"mm\"}", "cut.json: line 2, column 14: not JSON"},
      {"[]", "cut.json: must be an object"},
      {R"({"units": "mm", "strokes": []})", "cut.json: \"argil\" is missing"},
      {R"({"argil": 2, "units": "mm", "strokes": []})", "cut.json: argil: this program reads scripts of format 1"},
      {R"({"argil": 1.0, "units": "mm", "strokes": []})", "argil: this program"},
      {R"({"argil": 1, "units": "inch", "strokes": []})", "units: must be \"mm\""},
      {R"({"argil": 1, "units": "mm"})", "\"strokes\" is missing"},
      {R"({"argil": 1, "units": "mm", "strokes": [], "colour": 3})", "unknown key"},
      {R"({"argil": 1, "units": "mm", "strokes": {}})", "strokes: must be a list"},
      {R"({"argil": 1, "argil": 1, "units": "mm", "strokes": []})", "is there twice"},
      {withSetup("3"), "setup[0]: must be an object"},
      {withSetup("{}"), "setup[0]: must hold exactly one key"},
      {withSetup(R"({"voxel_mm": 0})"), "setup[0].voxel_mm: 0 is out of range"},
      {withSetup(R"({"up": "x"})"), "setup[0].up: unknown \"x\"; known are z, y, custom"},
      {withSetup(R"({"voxel_mm": 1}, {"voxel_mm": 1})"), "setup[1]: is there twice"},
      {withSetup(R"({"up": "y"}, {"up": "y"})"), "setup[1]: is there twice"},
      {withSetup(R"({"fit_mm": 5}, {"fit_mm": 5})"), "setup[1]: is there twice"},
      {withSetup(R"({"bits": 16}, {"bits": 16})"), "setup[1]: is there twice"},
      {withSetup(R"({"sphere": {"radius_mm": 5}}, {"import": "a.stl"})"), "setup[1]: the clay is already chosen"},
      {withSetup(R"({"block": {"size_mm": [1, 2]}})"), "setup[0].block.size_mm: must be 3 numbers"},
      {withSetup(R"({"block": {"size_mm": [1, 2, -3]}})"), "setup[0].block.size_mm: each side"},
      {withSetup(R"({"block": {"size_mm": [10, 20, 30], "round_mm": 6}})"),
       "setup[0].block.round_mm: 6 is out of range; use 0 to 5"},
      {withSetup(R"({"sphere": {"radius_mm": "5"}})"), "setup[0].sphere.radius_mm: must be a number"},
      {withSetup(R"({"import": ""})"), "setup[0].import: names no file"},
      {withStroke("null"), "strokes[1]: must be an object"},
      {withStroke(R"({"tool": "hammer", "radius_mm": 1, "path": [[0,0,0,0]]})"),
       "strokes[1].tool: unknown \"hammer\"; known are clay, carve, add, wax"},
      {withStroke(R"({"tool": "add", "radius_mm": 0, "path": [[0,0,0,0]]})"),
       "strokes[1].radius_mm: 0 is out of range"},
      {withStroke(R"({"tool": "add", "radius_mm": 1, "strength": 1, "path": [[0,0,0,0]]})"),
       "strokes[1]: unknown key \"strength\""},
      {withStroke(R"({"tool": "add", "radius_mm": 1, "drive": "foot", "path": [[0,0,0,0]]})"),
       "strokes[1].drive: unknown"},
      {withStroke(R"({"tool": "add", "radius_mm": 1, "onto": [0,0,-1], "path": [[0,0,0,0]]})"),
       "strokes[1]: \"press_mm\" is missing"},
      {withStroke(R"({"tool": "add", "radius_mm": 1, "press_mm": 1, "path": [[0,0,0,0]]})"),
       "strokes[1]: \"onto\" is missing"},
      {withStroke(R"({"tool": "add", "radius_mm": 1, "onto": [0,0,0], "press_mm": 1, "path": [[0,0,0,0]]})"),
       "strokes[1].onto: is no direction"},
      {withStroke(R"({"tool": "add", "radius_mm": 1})"), "strokes[1]: \"path\" is missing"},
      {withStroke(R"({"tool": "add", "radius_mm": 1, "path": []})"), "strokes[1].path: is empty"},
      {withStroke(R"({"tool": "add", "radius_mm": 1, "path": [[0,0,0]]})"), "strokes[1].path[0]: must be 4 numbers"},
      {withStroke(R"({"tool": "add", "radius_mm": 1, "path": [[0,0,0,0], [1,2,null,4]]})"),
       "strokes[1].path[1][2]: must be a number"},
      {withStroke(R"({"tool": "add", "radius_mm": 1, "path": [[0,0,0,0], [1,2,3,1e7]]})"),
       "strokes[1].path[1][3]: 10000000"},
      {withStroke(R"({"tool": "add", "radius_mm": 1, "path": [[0,0,0,1e999]]})"), "out of range"},
      {withStroke(R"({"tool": "add", "radius_mm": 1, "path": [[2,0,0,0], [1,0,0,0]]})"),
       "strokes[1].path[1]: its time 1 s comes before"},
      {std::string(5000, '['), "nest deeper"},
  };
  for (const auto& [text, expected] : faults) EXPECT_THAT(complaint(text), HasSubstr(expected)) << text.substr(0, 200);
}

// The example that the README names; `argil sculpt` takes a minute for it, so it is read alone.
TEST(Script, TheExampleCanBeRead) {
  std::ifstream in(ARGIL_SOURCE_DIR "/docs/owl.json", std::ios::binary);
  const std::string text((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  const Script script = parseScript(text, "owl.json");
  EXPECT_EQ(script.strokes.size() + script.operations.size(), 116u);
  EXPECT_EQ(parseScript(formatScript(script), "again"), script);
}

// Each row of the table with all that it takes, no parameter as the row begins: what is read is written again and read
// as the same, in the same place among strokes.
TEST(Script, OperationsComeBackAsTheyWere) {
  std::string steps;
  for (const PieceJob& row : pieceJobs()) {
    nlohmann::ordered_json step;
    step["operation"] = row.id;
    for (const auto& parameter : row.parameters) {
      PieceArguments arguments;
      parameter.change(arguments, parameter.standard == parameter.high ? parameter.low : parameter.high);
      step[keyOf(parameter)] = valueOf(parameter, arguments);
    }
    for (const std::string_view key : keysOf(row)) {
      if (key == "piece" || key == "name")
        step[std::string(key)] = "Öl \"1\"";
      else if (key == "pieces")
        step["pieces"] = {"A", "B"};
      else if (key == "plane" || key == "box")
        step[std::string(key)] = {1, 2, 3, 0.5, 5, 6};
      else if (key == "points")
        step["points"] = {{1, 2, 3}, {4, 5, 0.1}};
      else if (key == "closed")
        step["closed"] = true;
      else
        step[std::string(key)] = {1, -2, 0.25};
    }
    steps += (steps.empty() ? "" : ",") + step.dump() +
             R"(, {"tool": "add", "radius_mm": 1, "piece": "A", "path": [[0,0,0,0]]})";
  }
  steps += R"(, {"operation": "shell"}, {"operation": "fill-voids"})";
  const Script script = parseScript(R"({"argil": 1, "units": "mm", "strokes": [)" + steps + "]}", "steps.json");
  ASSERT_EQ(script.operations.size(), pieceJobs().size() + 2);
  ASSERT_EQ(script.strokes.size(), pieceJobs().size());
  for (size_t i = 0; i < pieceJobs().size(); ++i) {
    EXPECT_EQ(script.operations[i].id, pieceJobs()[i].id);
    EXPECT_EQ(script.operations[i].before, i);
    for (const auto& parameter : pieceJobs()[i].parameters)
      EXPECT_NE(parameter.get(script.operations[i].arguments), parameter.standard)
          << script.operations[i].id << ' ' << parameter.id;
  }
  EXPECT_EQ(script.operations.back().before, script.strokes.size());
  EXPECT_EQ(script.strokes[0].piece, "A");
  EXPECT_EQ(parseScript(formatScript(script), "again.json"), script);
}

TEST(Script, EveryTruncationIsRefused) {
  const std::string whole = kWhole;
  for (size_t length = 0; length < whole.size(); ++length) {
    EXPECT_THAT(complaint(whole.substr(0, length)), HasSubstr("not JSON")) << length;
  }
}

TEST(Script, WhatIsWrittenReadsBackToTheBit) {
  Script script = randomScript(3);
  script.voxelMm = 0.1;
  script.fitMm = 1.0 / 3;
  script.up = Up::custom;
  script.strokes[5].drive = Drive::hand;
  script.strokes[6].onto = Onto{Vec3d(0.1, 0, -1), 1.5};
  for (const ClaySetup& clay :
       {ClaySetup(), ClaySetup(BlockSetup{Vec3d(1, 2.5, 1e3), 0.1, Vec3d(-7, 0.3, 0)}),
        ClaySetup(SphereSetup{0.7, Vec3d(1, 1e-9, 3)}), ClaySetup(ImportSetup{"a b/\"c\".stl"})}) {
    script.clay = clay;
    EXPECT_EQ(parseScript(formatScript(script), "back"), script) << clay.index();
  }
  script.strokes[0].path[0].mm.x() = std::numeric_limits<double>::infinity();
  EXPECT_THROW((void)formatScript(script), Error);
}

TEST(Script, AFileKeepsItsImportBesideIt) {
  const fs::path folder = fs::temp_directory_path() / ("argil-script-" + std::to_string(::getpid()));
  fs::create_directories(folder);
  Script script = randomScript(4, {.strokes = 2});
  script.clay = ImportSetup{"scan.stl"};
  writeScript(folder / "s.json", script);
  const Script back = readScript(folder / "s.json");
  EXPECT_EQ(std::get<ImportSetup>(back.clay).file, folder / "scan.stl");
  EXPECT_EQ(back.strokes, script.strokes);
  EXPECT_THROW((void)readScript(folder), Error);
  EXPECT_THROW((void)readScript(folder / "missing.json"), Error);
  fs::remove_all(folder);
}

TEST(Script, RandomScriptsAreTheSameForASeedAndOfEveryKind) {
  const Script script = randomScript(9, {.strokes = 200});
  EXPECT_EQ(script, randomScript(9, {.strokes = 200}));
  EXPECT_NE(script, randomScript(10, {.strokes = 200}));
  size_t kinds[3] = {}, dabs = 0, repeats = 0, jumps = 0;
  for (const ScriptStroke& stroke : script.strokes) {
    ++kinds[stroke.tool.id == "carve" ? 0 : stroke.tool.id == "add" ? 1 : 2];
    dabs += stroke.path.size() == 1;
    for (size_t i = 0; i < stroke.path.size(); ++i) {
      EXPECT_LE(stroke.path[i].mm.norm(), 40 + 1e-9);
      if (i == 0) continue;
      const double step = (stroke.path[i].mm - stroke.path[i - 1].mm).norm();
      repeats += step == 0;
      jumps += step > 2 * stroke.tool.radiusMm;
    }
  }
  for (const size_t count : kinds) EXPECT_GT(count, 40u);
  EXPECT_GT(dabs, 5u);
  EXPECT_GT(repeats, 20u);
  EXPECT_GT(jumps, 20u);
}

}  // namespace
}  // namespace argil::engine
