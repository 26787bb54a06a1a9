// Instructions of the program's main work, as Callgrind counts them: they do not know how busy a machine is. What takes
// more than it did is found before it is noticed; what a scene does not use costs nothing.

#include <cpuid.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

namespace argil::tests {
namespace {

namespace fs = std::filesystem;
struct Count {
  double instructions = 0, allocations = 0;
};
using Counts = std::map<std::string, Count>;

constexpr double kMore = 1.02, kLess = 0.98;  // beside what is kept
// Of the work without a feature. Ticks are counted to the last instruction; a dab's depend a little on where memory
// lies.
constexpr double kNothingOfATick = 1e-6, kNothingOfADab = 1e-3;
constexpr double kFewOfDabs = 20;   // allocations of a hundred: as many more or less from run to run
constexpr double kFarPiece = 0.03;  // of a tick: a look at the box around a piece that is far away
const fs::path kKept = fs::path(ARGIL_SOURCE_DIR) / "docs/figures/instructions.csv";

// Valgrind tells programs that there is RDTSCP wherever there is AVX2, and then does not know it where the machine has
// none: some virtual ones.
bool hasRdtscp() {
  unsigned a = 0, b = 0, c = 0, d = 0;
  return __get_cpuid(0x80000001, &a, &b, &c, &d) != 0 && (d >> 27 & 1) != 0;
}

bool callgrind() {
  static const bool there =
      std::system("valgrind --version > /dev/null 2>&1") == 0 && __builtin_cpu_supports("avx2") && hasRdtscp();
  return there;
}

// Runs the work under Callgrind, in a folder of its own; instructions of each piece.
Counts count(const std::string& pieces, const std::string& before = "") {
  static int runs = 0;
  const fs::path folder = fs::current_path() / ("counts" + std::to_string(runs++));
  fs::create_directories(folder);
  const std::string command = "cd '" + folder.string() + "' && " + before +
                              " valgrind --tool=callgrind --instr-atstart=no --callgrind-out-file=out '" ARGIL_COUNTED
                              "' " +
                              pieces + " > said 2>&1";
  const int status = std::system(command.c_str());
  std::ifstream saidFile(folder / "said");
  std::stringstream said;
  said << saidFile.rdbuf();
  EXPECT_EQ(status, 0) << said.str();

  Counts counts;
  for (std::string line; std::getline(said, line);) {
    std::istringstream words(line);
    std::string name;
    if (double allocations; words >> name >> allocations) counts[name].allocations = allocations;
  }
  for (const fs::directory_entry& each : fs::directory_iterator(folder)) {
    std::ifstream file(each.path());
    std::string name;
    for (std::string line; std::getline(file, line);) {
      constexpr std::string_view kName = "desc: Trigger: Client Request: ", kTotals = "summary: ", kTotal = "totals: ";
      if (line.starts_with(kName)) name = line.substr(kName.size());
      if (name.empty()) continue;
      if (line.starts_with(kTotals)) counts[name].instructions = std::stod(line.substr(kTotals.size()));
      if (line.starts_with(kTotal)) counts[name].instructions = std::stod(line.substr(kTotal.size()));
    }
  }
  fs::remove_all(folder);
  return counts;
}

const Counts& all() {
  static const Counts counts = count("");
  return counts;
}

// The last line of the table.
Counts kept() {
  std::ifstream file(kKept);
  std::string line, names, last;
  std::getline(file, names);
  while (std::getline(file, line))
    if (!line.empty()) last = line;
  const auto cells = [](const std::string& text) {
    std::vector<std::string> out;
    std::stringstream stream(text);
    for (std::string cell; std::getline(stream, cell, ',');) out.push_back(cell);
    return out;
  };
  const std::vector<std::string> columns = cells(names), values = cells(last);
  Counts counts;
  for (size_t i = 1; i < std::min(columns.size(), values.size()); ++i)
    counts[columns[i]].instructions = std::stod(values[i]);
  return counts;
}

bool isWork(const std::string& name) {
  return name.find(':') == std::string::npos;
}

class CountsTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!callgrind()) GTEST_SKIP() << "needs valgrind, and a CPU with AVX2 and RDTSCP";
  }
};

TEST_F(CountsTest, NoWorkTakesMoreThanItDid) {
  const Counts before = kept();
  if (const char* day = std::getenv("ARGIL_KEEP_FIGURES")) {
    std::string names = "day", line = day;
    for (const auto& [name, counted] : all())
      if (isWork(name)) names += "," + name, line += "," + std::to_string(std::llround(counted.instructions));
    std::ifstream file(kKept);
    std::string first;
    std::getline(file, first);
    // Other names: other columns, and a new table.
    std::ofstream(kKept, first == names ? std::ios::app : std::ios::trunc)
        << (first == names ? "" : names + "\n") << line << "\n";
    return;
  }
  for (const auto& [name, counted] : all()) {
    if (!isWork(name)) continue;
    ASSERT_TRUE(before.count(name)) << name << " is not in " << kKept;
    const double ratio = counted.instructions / before.at(name).instructions;
    std::printf("%-12s %12.0f instructions, %+.3f %%\n", name.c_str(), counted.instructions, 100 * (ratio - 1));
    EXPECT_LE(ratio, kMore) << name << ": if that is meant, keep a new line with ARGIL_KEEP_FIGURES=DAY";
    if (ratio < kLess) std::printf("%s takes less: keep a new line with ARGIL_KEEP_FIGURES=DAY\n", name.c_str());
  }
  EXPECT_EQ(static_cast<size_t>(std::count_if(all().begin(), all().end(), [](auto& e) { return isWork(e.first); })),
            before.size());
}

TEST_F(CountsTest, ASlowdownOfThreeInAHundredIsFound) {
  const std::string names = "carve-kernel,wide-distance-kernel,tick";
  const Counts plain = count(names), slower = count(names, "ARGIL_COUNT_MORE=3");
  for (const char* name : {"carve-kernel", "wide-distance-kernel", "tick"}) {
    const double same = plain.at(name).instructions / all().at(name).instructions,
                 more = slower.at(name).instructions / all().at(name).instructions;
    std::printf("%s: again %+.4f %%, three of a hundred more %+.3f %%\n", name, 100 * (same - 1), 100 * (more - 1));
    EXPECT_NEAR(same, 1, 5e-4);
    EXPECT_GT(more, kMore);
  }
}

TEST_F(CountsTest, WhatASceneDoesNotUseCostsNothing) {
  int looked = 0;
  for (const auto& [name, counted] : all()) {
    if (isWork(name)) continue;
    const std::string work = name.substr(0, name.find(':'));
    const Count& without = all().at(work + ":none");
    const double ratio = counted.instructions / without.instructions - 1;
    std::printf("%-18s %+.4f %% of instructions, %+.0f of %.0f allocations\n", name.c_str(), 100 * ratio,
                counted.allocations - without.allocations, without.allocations);
    EXPECT_LE(std::abs(counted.allocations - without.allocations), work == "tick" ? 0 : kFewOfDabs) << name;
    if (name == "tick:piece-far-away") {
      EXPECT_LE(ratio, kFarPiece);
      continue;
    }
    EXPECT_LE(std::abs(ratio), work == "tick" ? kNothingOfATick : kNothingOfADab) << name;
    ++looked;
  }
  EXPECT_GE(looked, 16);
}

TEST_F(CountsTest, WhatIsPlantedIsFound) {
  for (const char* what : {"branch", "allocation"}) {
    const Counts counts = count("dab:none,tick:none", std::string("ARGIL_COUNT_PLANTED=") + what);
    for (const char* name : {"dab:none", "tick:none"}) {
      const Count &is = counts.at(name), &was = all().at(name);
      std::printf("a planted %s: %s %+.4f %%, %+.0f allocations\n", what, name,
                  100 * (is.instructions / was.instructions - 1), is.allocations - was.allocations);
      if (what == std::string("allocation")) {
        EXPECT_GT(is.allocations, was.allocations + kFewOfDabs) << name;
      }
      const double least = name == std::string("tick:none") ? kNothingOfATick : -kNothingOfADab;
      EXPECT_GT(is.instructions / was.instructions - 1, least) << name;
    }
  }
}

}  // namespace
}  // namespace argil::tests
