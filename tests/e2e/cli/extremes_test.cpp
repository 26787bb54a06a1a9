// `argil bench extremes` beside what docs/extremes.csv keeps of it: no margin shrinks by a tenth, no relation that held
// to the bit breaks. ARGIL_KEEP_FIGURES=1 writes the table anew.

#include <gtest/gtest.h>

#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/e2e/support/command.h"

namespace argil::tests {
namespace {

using nlohmann::json;

struct Margin {
  std::string unit;
  double value = 0;
};

TEST(Extremes, NoMarginShrinks) {
  const Scratch scratch;
  const std::string file = (scratch / "extremes.json").string();
  const Outcome outcome = argil({"bench", "extremes", "--json", file});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const json results = json::parse(slurp(file))["results"];
  std::map<std::string, Margin> now;
  for (const json& row : results)
    now[row["name"].get<std::string>().substr(std::string("extremes/").size())] = {row["unit"], row["median"]};
  const std::string kept = ARGIL_SOURCE_DIR "/docs/extremes.csv";
  if (std::getenv("ARGIL_KEEP_FIGURES")) {
    std::ofstream out(kept);
    out << "extreme,unit,margin\n";
    for (const auto& [name, margin] : now) {
      std::ostringstream value;
      value.precision(3);
      value << margin.value;
      out << name << "," << margin.unit << "," << value.str() << "\n";
    }
    return;
  }
  std::ifstream in(kept);
  std::string line;
  std::getline(in, line);
  size_t rows = 0;
  while (std::getline(in, line)) {
    const size_t unit = line.find(','), value = line.rfind(',');
    ASSERT_TRUE(unit != std::string::npos && value > unit) << line;
    const std::string name = line.substr(0, unit);
    const double margin = std::stod(line.substr(value + 1));
    ++rows;
    ASSERT_TRUE(now.count(name)) << name << " is kept, but nobody measures it";
    EXPECT_EQ(now[name].unit, line.substr(unit + 1, value - unit - 1)) << name;
    EXPECT_GE(now[name].value, (now[name].unit == "digits" ? 0.9 : 1.0) * margin) << name;
  }
  EXPECT_EQ(rows, now.size()) << "run with ARGIL_KEEP_FIGURES=1 and look at the difference";
  EXPECT_GT(rows, 150u);
}

}  // namespace
}  // namespace argil::tests
