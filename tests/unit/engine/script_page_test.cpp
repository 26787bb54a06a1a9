// The page on scripts says what scripts are read by: it is made from the tables, and every key that is read stands on
// it.

#include "engine/text/script_page.h"

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>
#include <sstream>

#include "clay/base/error.h"
#include "clay/store/store.h"
#include "engine/models/prepare_clay.h"
#include "engine/session/run.h"
#include "engine/text/guide_setup.h"
#include "engine/text/operation_text.h"
#include "engine/text/parameter_text.h"
#include "engine/text/script.h"
#include "engine/tools/piece_jobs.h"
#include "engine/tools/tool_table.h"

namespace argil::engine {
namespace {

using nlohmann::json;

std::string complaint(const json& script) {
  try {
    (void)parseScript(script.dump(), "s.json");
  } catch (const Error& error) {
    return error.what();
  }
  return {};
}

// What the reader says that it knows, where it meets a key that it does not.
std::set<std::string> known(json script, const json::json_pointer& where) {
  script[where]["nonsense"] = 1;
  const std::string said = complaint(script);
  const std::string before = "known are ";
  const size_t at = said.find(before);
  EXPECT_NE(at, std::string::npos) << where.to_string() << ": " << said;
  if (at == std::string::npos) return {};
  std::set<std::string> keys;
  std::istringstream words(said.substr(at + before.size()));
  for (std::string word; words >> word;) keys.insert(word.substr(0, word.find(',')));
  return keys;
}

std::set<std::string> fieldsOf(std::string_view where) {
  std::set<std::string> keys;
  for (const ScriptField& field : scriptFields())
    if (field.where == where) keys.insert(std::string(field.key));
  return keys;
}

json script(const char* setup, const char* step = R"({"tool": "carve", "radius_mm": 2, "path": [[0, 0, 0, 0]]})") {
  return {{"argil", 1},
          {"units", "mm"},
          {"setup", json::array({json::parse(setup)})},
          {"strokes", json::array({json::parse(step)})}};
}

TEST(ScriptPage, DocsHoldThePageThatTheProgramPrints) {
  std::ifstream in(ARGIL_SOURCE_DIR "/docs/scripts.md", std::ios::binary);
  std::ostringstream text;
  text << in.rdbuf();
  EXPECT_EQ(text.str(), scriptPage()) << "run `argil tools --scripts > docs/scripts.md`";
}

TEST(ScriptPage, EveryKeyThatIsReadIsAFieldOfThePage) {
  using Pointer = json::json_pointer;
  const json plain = script(R"({"voxel_mm": 1})");
  EXPECT_EQ(known(plain, Pointer("")), fieldsOf("script"));
  EXPECT_EQ(known(plain, Pointer("/setup/0")), fieldsOf("setup"));
  EXPECT_EQ(known(script(R"({"block": {"size_mm": [1, 1, 1]}})"), Pointer("/setup/0/block")), fieldsOf("block"));
  EXPECT_EQ(known(script(R"({"sphere": {"radius_mm": 1}})"), Pointer("/setup/0/sphere")), fieldsOf("sphere"));
  EXPECT_EQ(known(script(R"({"materials": [{"name": "a"}]})"), Pointer("/setup/0/materials/0")),
            fieldsOf("materials[]"));
  const char* around =
      R"({"tool": "carve", "radius_mm": 2, "radial": {"turns": 2, "axis": [0, 0, 0, 0, 0, 1]}, "path": [[0, 0, 0, 0]]})";
  EXPECT_EQ(known(script(R"({"voxel_mm": 1})", around), Pointer("/strokes/0/radial")), fieldsOf("radial"));
  // Strokes: the fields and the numbers of each tool.
  const std::string page = scriptPage();
  for (const ToolRow& row : toolTable()) {
    std::set<std::string> expected = fieldsOf("stroke");
    if (row.file == ToolFile::none) expected.erase("file");
    for (const auto& parameter : row.parameters) expected.insert(keyOf(parameter));
    json stroke = plain;
    stroke["strokes"][0]["tool"] = row.id;
    EXPECT_EQ(known(stroke, Pointer("/strokes/0")), expected) << row.id;
    EXPECT_NE(page.find(std::string("\n| `").append(row.id) + "` | "), std::string::npos) << row.id;
    for (const auto& parameter : row.parameters)
      EXPECT_NE(page.find("\n| `" + keyOf(parameter) + "` | "), std::string::npos) << keyOf(parameter);
  }
  for (const PieceJob& row : pieceJobs()) {
    const size_t at = page.find(std::string("\n`").append(row.id) + "`: " + std::string(row.help));
    ASSERT_NE(at, std::string::npos) << row.id;
    const std::string section = page.substr(at, page.find("\n`", at + 2) - at);
    std::set<std::string> expected{"operation"};
    for (const auto& parameter : row.parameters) {
      expected.insert(keyOf(parameter));
      EXPECT_NE(section.find("| `" + keyOf(parameter) + "` | "), std::string::npos)
          << row.id << " " << keyOf(parameter);
    }
    for (const std::string_view key : keysOf(row)) {
      expected.insert(std::string(key));
      EXPECT_NE(section.find("`" + std::string(key) + "`"), std::string::npos) << row.id << " " << key;
    }
    json step = plain;
    step["strokes"][0] = {{"operation", row.id}};
    EXPECT_EQ(known(step, Pointer("/strokes/0")), expected) << row.id;
  }
  for (const GuideKind& kind : guideKinds()) {
    std::set<std::string> expected{"guide", "while_buttons"};
    for (const std::string_view key : kind.keys) expected.insert(std::string(key));
    json guide = script(R"({"guides": [{}]})");
    guide["setup"][0]["guides"][0]["guide"] = kind.name;
    EXPECT_EQ(known(guide, Pointer("/setup/0/guides/0")), expected) << kind.name;
    EXPECT_NE(page.find(std::string("| `").append(kind.name) + "` |"), std::string::npos) << kind.name;
  }
  std::set<std::string> properties;
  for (const MaterialKey& key : materialKeys()) properties.insert(std::string(key.key));
  EXPECT_EQ(known(script(R"({"material": {}})"), Pointer("/setup/0/material")), properties);
}

// The ranges of numbers that the page gives are those at which the reader stops.
TEST(ScriptPage, RangesAreThoseOfTheReader) {
  for (const MaterialKey& key : materialKeys()) {
    if (key.key == "dynamic_friction") continue;  // bounded by the other one too
    for (const double value : {key.least, key.most}) {
      json each = script(R"({"material": {}})");
      each["setup"][0]["material"][std::string(key.key)] = value;
      EXPECT_EQ(complaint(each), "") << key.key;
      each["setup"][0]["material"][std::string(key.key)] = value == key.most ? 2 * value + 1 : value - 1;
      EXPECT_NE(complaint(each), "") << key.key;
    }
  }
  const auto setup = [](const char* key, double value) {
    json each = script("{}");
    each["setup"][0][key] = value;
    return complaint(each);
  };
  for (const double good : {0.001, 1000.0}) EXPECT_EQ(setup("voxel_mm", good), "");
  for (const double bad : {0.0009, 1001.0}) EXPECT_NE(setup("voxel_mm", bad), "");
  for (const double good : {16, 32}) EXPECT_EQ(setup("bits", good), "");
  EXPECT_NE(setup("bits", 24), "");
  json twice = script("{\"bits\": 16}");
  twice["setup"].push_back({{"bits", 16}});
  EXPECT_NE(complaint(twice).find("is there twice"), std::string::npos) << complaint(twice);
  const auto turns = [](int count) {
    json each = script("{\"voxel_mm\": 1}");
    each["strokes"][0]["radial"] = {{"turns", count}, {"axis", {0, 0, 0, 0, 0, 1}}};
    return complaint(each);
  };
  EXPECT_EQ(turns(kMostTurns), "");
  EXPECT_NE(turns(kMostTurns + 1), "");
  for (const ScriptField& field : scriptFields())
    if (field.key == "turns") {
      EXPECT_EQ(field.values, "1 to " + std::to_string(kMostTurns));
    }
}

TEST(ScriptPage, ItsExamplesRun) {
  const std::string page = scriptPage();
  for (const std::string_view text : scriptExamples()) {
    EXPECT_NE(page.find(text), std::string::npos);
    const Script script = parseScript(text, "example");
    PreparedClay clay = prepareClay(clay::Store::make(), script);
    Session session(std::move(clay.document));
    clay::Surface surface;
    const RunReport report = runScript(session, surface, script);
    EXPECT_EQ(report.idle, 0u) << (report.notes.empty() ? std::string() : report.notes.back());
    EXPECT_GT(session.undoSteps(), 0u);
  }
}

}  // namespace
}  // namespace argil::engine
