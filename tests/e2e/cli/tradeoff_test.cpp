// The presets of quality, and docs/tradeoff.md, beside the table that was measured: whoever changes one of them has to
// measure, or to say why.

#include <gtest/gtest.h>

#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>
#include <vector>

#include "tests/e2e/support/command.h"

namespace argil::tests {
namespace {

using nlohmann::json;

const std::string kDocs = ARGIL_SOURCE_DIR "/docs";

std::vector<std::string> cells(const std::string& line) {
  std::vector<std::string> all;
  std::istringstream stream(line);
  for (std::string cell; std::getline(stream, cell, '|');) all.push_back(cell);
  return all;
}

// "`band=4 passes=2`" by axis.
std::map<std::string, double> axesIn(const std::string& cell) {
  std::map<std::string, double> axes;
  const size_t from = cell.find('`'), to = cell.rfind('`');
  if (from == std::string::npos) return axes;
  std::istringstream words(cell.substr(from + 1, to - from - 1));
  for (std::string word; words >> word;) {
    const size_t equals = word.find('=');
    axes[word.substr(0, equals)] = std::stod(word.substr(equals + 1));
  }
  return axes;
}

TEST(Tradeoff, ThePageAndThePresetsFollowFromTheTable) {
  const Scratch scratch;
  const Outcome made =
      argil({"bench", "tradeoff", "--from", kDocs + "/tradeoff.csv", "--folder", (scratch / "made").string()});
  ASSERT_EQ(made.code, 0) << made.err;
  const std::string page = slurp(scratch / "made" / "tradeoff.md");
  EXPECT_EQ(page, slurp(kDocs + "/tradeoff.md"));
  EXPECT_EQ(slurp(scratch / "made" / "tradeoff.svg"), slurp(kDocs + "/tradeoff.svg"));
  EXPECT_EQ(slurp(scratch / "made" / "tradeoff.csv"), slurp(kDocs + "/tradeoff.csv"));

  const Outcome tools = argil({"tools", "--quality", "--json"});
  ASSERT_EQ(tools.code, 0) << tools.err;
  const json axes = json::parse(tools.out);
  const std::vector<std::string> parts{"clay", "strokes", "touch", "surface"};
  std::istringstream lines(page);
  int presets = 0;
  for (std::string line; std::getline(lines, line);) {
    for (const char* preset : {"draft", "balanced", "fine"}) {
      if (line.rfind(std::string("| ") + preset + " |", 0) != 0) continue;
      ++presets;
      const auto row = cells(line);
      ASSERT_GE(row.size(), 6u) << line;
      for (size_t i = 0; i < parts.size(); ++i) {
        const auto changed = axesIn(row[i + 2]);
        for (const json& axis : axes) {
          if (axis["part"] != parts[i] || axis["id"] == "exported") continue;
          const auto it = changed.find(axis["id"].get<std::string>());
          const double wanted = it == changed.end() ? axis["begins"].get<double>() : it->second;
          EXPECT_EQ(axis[preset].get<double>(), wanted) << preset << " " << axis["id"];
        }
      }
    }
  }
  EXPECT_EQ(presets, 3);
}

TEST(Tradeoff, AnythingElseIsNoTable) {
  const Scratch scratch;
  const std::string file = (scratch / "t.csv").string();
  for (const char* text : {"", "a,b\n", "part,quality,workload,rms,most,unit,cost,cost low,cost high,bytes\nclay,,x\n",
                           "part,quality,workload,rms,most,unit,cost,cost low,cost high,bytes\n"
                           "clay,,ball,x,1,mm,1,1,1,1\n",
                           "part,quality,workload,rms,most,unit,cost,cost low,cost high,bytes\n"
                           "wood,,ball,1,1,mm,1,1,1,1\n"}) {
    std::ofstream(file) << text;
    const Outcome outcome = argil({"bench", "tradeoff", "--from", file, "--folder", (scratch / "made").string()});
    EXPECT_EQ(outcome.code, 2) << text;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_FALSE(fs::exists(scratch / "made" / "tradeoff.csv"));
  }
}

}  // namespace
}  // namespace argil::tests
