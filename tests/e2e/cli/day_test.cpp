// What `argil bench day` measures, by counts that are equal on every machine: bricks and bytes, never times.

#include <nlohmann/json.hpp>

#include "tests/e2e/support/command.h"
#include "tests/support/tier.h"

namespace argil::tests {
namespace {

using nlohmann::json;

json bench(const Scratch& scratch, std::vector<std::string> arguments) {
  const std::string file = (scratch / "day.json").string();
  arguments.insert(arguments.begin(), "bench");
  arguments.insert(arguments.end(), {"--json", file, "--overwrite"});
  const Outcome outcome = argil(arguments);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return json::parse(slurp(file))["results"];
}

const json* find(const json& results, const std::string& name) {
  for (const json& row : results)
    if (row["name"] == name) return &row;
  return nullptr;
}

// Twice as long a stroke computes as many bricks for a second of hand, and takes no memory that does not become clay.
TEST(Day, AStrokeCostsTheSameHoweverLongItLasts) {
  const Scratch scratch;
  // Those that cut, that move a surface along, that mend it and that drag it.
  std::vector<std::string> tools = {"carve", "inflate", "smooth", "tug"};
  if (longTier()) tools.insert(tools.end(), {"add", "melt", "scrape", "layer"});
  std::vector<std::string> arguments = {"day-strokes", "--largest", "0.8",    "--stroke", "20",
                                        "--cell",      "600",       "--tips", "12"};
  arguments.push_back("--tools");
  arguments.insert(arguments.end(), tools.begin(), tools.end());
  const json results = bench(scratch, arguments);
  for (const std::string& tool : tools) {
    SCOPED_TRACE(tool);
    const json* ten = find(results, "day/stroke/" + tool + "/r12/0.8M/10s");
    const json* twenty = find(results, "day/stroke/" + tool + "/r12/0.8M/20s");
    ASSERT_TRUE(ten && twenty);
    EXPECT_GT((*ten)["bricks"].get<double>(), 1000);
    EXPECT_LE((*twenty)["bricks"].get<double>(), 1.2 * (*ten)["bricks"].get<double>());
    EXPECT_LE((*twenty)["bytes"].get<double>(), 2 * (*twenty)["memory"].get<double>() + (64 << 20));
  }
}

TEST(Day, APieceTakesLittleBesideItsClay) {
  const Scratch scratch;
  const json results = bench(scratch, {"day-pieces"});
  const json* memory = find(results, "day/pieces/1000/memory");
  ASSERT_TRUE(memory);
  EXPECT_LE((*memory)["median"].get<double>(), 100'000);
}

TEST(Day, HoursOfWorkEndAsTheyBegan) {
  const Scratch scratch;
  const json results =
      bench(scratch, {"day-hours", "--hours", longTier() ? "0.1" : "0.025", "--folder", scratch.path().string()});
  const json *first = find(results, "day/hours/batch/quarter1"), *last = find(results, "day/hours/batch/quarter4");
  ASSERT_TRUE(first && last);
  EXPECT_GT((*last)["n"].get<int>(), 100);
  // The history is within its budget from the first quarter on or still filling up to it: never beyond.
  EXPECT_LE((*last)["memory"].get<double>(), 1.2 * (*first)["memory"].get<double>() + (192 << 20));
}

TEST(Day, ACommandWithoutItsBenchmarksSaysHowToMakeThem) {
  const Scratch alone;
  fs::copy_file(ARGIL_COMMAND, alone / "argil");
  const Outcome outcome = argil({"bench", "edit"}, -1, (alone / "argil").string());
  EXPECT_EQ(outcome.code, 2);
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(outcome.err.find("--target argil-bench"), std::string::npos) << outcome.err;
}

TEST(Day, OptionsThatAreWrongAreNamed) {
  for (const std::vector<std::string>& call :
       std::vector<std::vector<std::string>>{{"bench", "day", "--stroke", "0"},
                                             {"bench", "day", "--tools", "hammer"},
                                             {"bench", "day", "--tips", "0.1"},
                                             {"bench", "day", "--hours", "-1"},
                                             {"bench", "night"}}) {
    const Outcome outcome = argil(call);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_NE(outcome.err.find(call.size() > 2 ? call[2] : call[1]), std::string::npos) << outcome.err;
  }
}

}  // namespace
}  // namespace argil::tests
