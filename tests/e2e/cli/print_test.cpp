// `argil inspect --print`: what stands in the way of printing, in words and as JSON.

#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <string>

#include "tests/e2e/support/command.h"

namespace argil::tests {
namespace {

using nlohmann::json;

class PrintCheck : public ::testing::Test {
 protected:
  std::string sculpted(const std::string& setup) {
    std::ofstream(scratch_ / "script.json")
        << R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.25}, )" << setup << R"(], "strokes": []})";
    const fs::path file = scratch_ / "clay.argil";
    const Outcome o = argil({"sculpt", (scratch_ / "script.json").string(), "-o", file.string()});
    EXPECT_EQ(o.code, 0) << o.err;
    return file.string();
  }
  Scratch scratch_;
};

TEST_F(PrintCheck, ASoundPieceHasNothingInItsWay) {
  const std::string file = sculpted(R"({"block": {"size_mm": [20, 20, 10]}})");
  const Outcome said = argil({"inspect", file, "--print", "fdm"});
  EXPECT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("nothing stands in the way"), std::string::npos) << said.out;
}

TEST_F(PrintCheck, AThinPlateIsToldWithItsPlace) {
  const std::string file = sculpted(R"({"block": {"size_mm": [20, 20, 0.6]}})");
  const Outcome said = argil({"inspect", file, "--print", "sla", "--json"});
  ASSERT_EQ(said.code, 0) << said.err;
  const json print = json::parse(said.out)["pieces"][0]["print"];
  ASSERT_EQ(print["walls"]["parts"].size(), 1u);
  EXPECT_NEAR(print["walls"]["parts"][0]["least_mm"].get<double>(), 0.6, 0.13);
  EXPECT_NEAR(print["walls"]["parts"][0]["area_mm2"].get<double>(), 800, 60);
  EXPECT_EQ(print["troubles"], 1);
  // A limit of one's own.
  const Outcome own = argil({"inspect", file, "--print", "sla", "--wall", "0.4", "--json"});
  EXPECT_EQ(json::parse(own.out)["pieces"][0]["print"]["troubles"], 0);
}

TEST_F(PrintCheck, PiecesThatMeetAreToldWithTheirNames) {
  const std::string script = (scratch_ / "meet.json").string(), report = (scratch_ / "report.json").string(),
                    clay = (scratch_ / "meet.argil").string();
  std::ofstream(script)
      << R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.25}, {"block": {"size_mm": [20, 20, 4]}}],
    "strokes": [{"operation": "cylinder", "radius_mm": 3, "height_mm": 10, "centre_mm": [0, 0, 6], "name": "Post"},
                {"operation": "cylinder", "radius_mm": 3, "height_mm": 10, "centre_mm": [6.2, 0, 30], "name": "Far"},
                {"operation": "cylinder", "radius_mm": 3, "height_mm": 10, "centre_mm": [0, 0, 30], "name": "Near"}],
    "print": {"process": "fdm"}})";
  const Outcome said = argil({"sculpt", script, "-o", clay, "--report", report});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("pieces        Clay and Post overlap, 1 mm deep at"), std::string::npos) << said.out;
  EXPECT_NE(said.out.find("pieces        Far and Near are 0.2"), std::string::npos) << said.out;
  std::ifstream in(report);
  const json met = json::parse(in)["pieces_that_meet"];
  const Outcome inspected = argil({"inspect", clay, "--print", "fdm", "--json"});
  EXPECT_EQ(json::parse(inspected.out)["pieces_that_meet"], met);
  ASSERT_EQ(met.size(), 2u);
  EXPECT_EQ(met[0]["pieces"], (json{"Clay", "Post"}));
  EXPECT_EQ(met[0]["overlap"], true);
  EXPECT_NEAR(met[1]["mm"].get<double>(), 0.2, 0.05);
  // Narrower gaps are allowed.
  const Outcome finer = argil({"inspect", clay, "--print", "fdm", "--gap", "0.1"});
  EXPECT_EQ(finer.out.find("Near are"), std::string::npos) << finer.out;
  EXPECT_NE(finer.out.find("Clay and Post overlap"), std::string::npos) << finer.out;
}

TEST_F(PrintCheck, AScriptAsksForIt) {
  const std::string script = (scratch_ / "asks.json").string(), report = (scratch_ / "report.json").string(),
                    recorded = (scratch_ / "recorded.json").string(), clay = (scratch_ / "clay.argil").string();
  const auto put = [&](const std::string& print) {
    std::ofstream(script)
        << R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.25}, {"block": {"size_mm": [20, 20, 0.6]}}],
    "strokes": [{"operation": "cylinder", "radius_mm": 5, "height_mm": 10, "centre_mm": [0, 0, 20], "name": "Post"}], "print": )"
        << print << "}";
  };
  put(R"({"process": "sla", "wall_mm": 0.9})");
  const Outcome said = argil({"sculpt", script, "--report", report, "--record", recorded});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("Clay: printed in resin"), std::string::npos) << said.out;
  EXPECT_NE(said.out.find("thinner than 0.9 mm"), std::string::npos) << said.out;
  // Each piece by itself; what is written back asks the same.
  for (const std::string& each : {script, recorded}) {
    ASSERT_EQ(argil({"sculpt", each, "--report", report, "--overwrite"}).code, 0);
    std::ifstream in(report);
    const json print = json::parse(in)["print"];
    ASSERT_EQ(print.size(), 2u);
    EXPECT_EQ(print[0]["name"], "Clay");
    EXPECT_EQ(print[0]["print"]["walls"]["limit_mm"], 0.9);
    EXPECT_EQ(print[0]["print"]["walls"]["parts"].size(), 1u);
    EXPECT_EQ(print[1]["name"], "Post");
    EXPECT_EQ(print[1]["print"]["walls"]["parts"].size(), 0u);
  }
  // Ways out of hollows, by their own limit.
  std::ofstream(script)
      << R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.25}, {"block": {"size_mm": [16, 16, 16]}}], "strokes": [
    {"operation": "shell", "inner_mm": 3, "outer_mm": 0},
    {"operation": "cylinder", "radius_mm": 0.8, "height_mm": 10, "round_mm": 0, "centre_mm": [0, 0, -8], "name": "Bore"},
    {"operation": "cut", "pieces": ["Clay", "Bore"]}], "print": {"process": "sls", "outlet_mm": 1.8}})";
  const Outcome bored = argil({"sculpt", script, "-o", clay});
  ASSERT_EQ(bored.code, 0) << bored.err;
  EXPECT_NE(bored.out.find("ways out    1 hollow opens by less than 1.8 mm"), std::string::npos) << bored.out;
  EXPECT_EQ(json::parse(argil({"inspect", clay, "--print", "sls", "--json"}).out)["pieces"][0]["print"]["necks"].size(),
            1u);
  EXPECT_NE(argil({"inspect", clay, "--print", "sls", "--outlet", "1.4"}).out.find("no hollow opens by less than 1.4"),
            std::string::npos);
  fs::remove(clay);
  // What cannot be looked at takes nothing of the work along.
  put(R"({"process": "sla", "wall_mm": 900})");
  const Outcome beyond = argil({"sculpt", script, "-o", clay});
  EXPECT_EQ(beyond.code, 2);
  EXPECT_EQ(std::count(beyond.err.begin(), beyond.err.end(), '\n'), 1) << beyond.err;
  EXPECT_TRUE(fs::remove(clay));
  for (const char* bad : {R"({"process": "clay"})", R"({"wall_mm": 1})", R"({"process": "sla", "wall_mm": 0})",
                          R"({"process": "sla", "gap_mm": 1001})", R"({"process": "sla", "outlet_mm": 0})",
                          R"({"process": "sla", "walls": 1})", "[]"}) {
    put(bad);
    const Outcome refused = argil({"sculpt", script, "-o", clay});
    EXPECT_EQ(refused.code, 2) << bad;
    EXPECT_EQ(std::count(refused.err.begin(), refused.err.end(), '\n'), 1) << refused.err;
    EXPECT_NE(refused.err.find("asks.json: print"), std::string::npos) << refused.err;
    EXPECT_FALSE(fs::exists(clay)) << bad;
  }
}

TEST_F(PrintCheck, AMouldsUndercutsAreTold) {
  // A bore across z and along y.
  std::ofstream(scratch_ / "bored.json")
      << R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.25}, {"block": {"size_mm": [20, 20, 20]}}],
    "strokes": [{"operation": "cylinder", "radius_mm": 4, "height_mm": 30, "axis": [0, 1, 0], "name": "Bore"},
                {"operation": "cut", "pieces": ["Clay", "Bore"]}]})";
  const std::string file = (scratch_ / "bored.argil").string();
  ASSERT_EQ(argil({"sculpt", (scratch_ / "bored.json").string(), "-o", file}).code, 0);
  const auto mould = [&](const std::string& pull) {
    const Outcome said = argil({"inspect", file, "--pull", pull, "--draft", "1", "--json"});
    EXPECT_EQ(said.code, 0) << said.err;
    return json::parse(said.out)["pieces"][0]["mould"];
  };
  // Both halves of the bore's wall.
  EXPECT_NEAR(mould("z")["undercut_mm2"].get<double>(), 2 * 3.14159 * 4 * 20, 25);
  EXPECT_EQ(mould("0,0,-3")["undercuts"].size(), mould("z")["undercuts"].size());
  EXPECT_LT(mould("y")["undercut_mm2"].get<double>(), 1);
  const json best = mould("best");
  EXPECT_NEAR(std::abs(best["pull"][1].get<double>()), 1, 0.01);
  const Outcome words = argil({"inspect", file, "--pull", "z"});
  EXPECT_NE(words.out.find("from a mould, pulled along (0.000, 0.000, 1.000)"), std::string::npos) << words.out;
  EXPECT_NE(words.out.find("less than 2°"), std::string::npos) << words.out;
}

TEST_F(PrintCheck, BadWordsAreOneLine) {
  const std::string file = sculpted(R"({"block": {"size_mm": [20, 20, 10]}})");
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"--print", "clay"},
                                             {"--wall", "1"},
                                             {"--print", "sla", "--wall", "-1"},
                                             {"--draft", "2"},
                                             {"--pull", "up"},
                                             {"--pull", "0,0,0"},
                                             {"--pull", "1,2"},
                                             {"--pull", "1,2,3,4"},
                                             {"--pull", "1,2,nan"},
                                             {"--pull", "z", "--draft", "60"},
                                             {"--print", "sla", "--wall", "100"}}) {
    std::vector<std::string> all{"inspect", file};
    all.insert(all.end(), words.begin(), words.end());
    const Outcome said = argil(all);
    EXPECT_EQ(said.code, 2) << said.out;
    EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1) << said.err;
  }
}

// The whole way from a shape to what a printer gets: halves that find their place, hollow, and nothing stays in them.
TEST_F(PrintCheck, AScriptMakesAPieceReadyToPrint) {
  std::ofstream(scratch_ / "ready.json")
      << R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.4}, {"sphere": {"radius_mm": 25}}], "strokes": [
            {"operation": "cut-plane", "plane": [0, 0, -20, 0, 0, 1]},
            {"operation": "cut-pegs", "plane": [0, 0, 2, 0, 0, 1], "clearance_mm": 0.2},
            {"operation": "shell", "inner_mm": 2.4},
            {"operation": "drain", "diameter_mm": 3.5},
            {"operation": "shell", "piece": "Clay, other side", "inner_mm": 2.4},
            {"operation": "infill", "piece": "Clay, other side", "kind": "struts", "wall_mm": 1.6, "density_percent": 10},
            {"operation": "drain", "piece": "Clay, other side", "diameter_mm": 3.5}]})";
  const fs::path file = scratch_ / "ready.argil";
  const Outcome made = argil({"sculpt", (scratch_ / "ready.json").string(), "-o", file.string()});
  ASSERT_EQ(made.code, 0) << made.err;
  for (const char* words : {"2 pegs", "holes", "% of"}) EXPECT_NE(made.out.find(words), std::string::npos) << made.out;
  const Outcome said = argil({"inspect", file.string(), "--print", "sla", "--json"});
  ASSERT_EQ(said.code, 0) << said.err;
  const json pieces = json::parse(said.out)["pieces"];
  ASSERT_EQ(pieces.size(), 2u);
  for (const json& piece : pieces)
    for (const json& trap : piece["print"]["traps"]) EXPECT_FALSE(trap["closed"].get<bool>()) << piece.dump(1);
}

}  // namespace
}  // namespace argil::tests
