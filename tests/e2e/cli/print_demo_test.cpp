// scripts/print_demo.sh: a shape becomes parts that a slicer takes without a word, and a solid with its bound.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <string>

#include "tests/e2e/support/referees.h"

namespace argil::tests {
namespace {

size_t countOf(const std::string& text, const std::string& words) {
  size_t count = 0;
  for (size_t at = text.find(words); at != std::string::npos; at = text.find(words, at + 1)) ++count;
  return count;
}

void goesTheWholeWay(const std::string& mesh) {
  const Scratch scratch;
  const std::string script = std::string(ARGIL_SOURCE_DIR) + "/scripts/print_demo.sh";
  std::string said = outputOf("ARGIL=" ARGIL_COMMAND " " + script + " '" + mesh + "' out", scratch.path());
  EXPECT_NE(said.find("smooth faces"), std::string::npos) << said;
  EXPECT_NE(said.find("(bound "), std::string::npos) << said;
  EXPECT_GT(fs::file_size(scratch / "out/whole.step"), 100000u);
  // Cut in two that hang together, one hollow each, and nothing stays in them.
  EXPECT_NE(said.find("2 pegs"), std::string::npos) << said;
  EXPECT_EQ(countOf(said, "none that hold a liquid"), 2u) << said;
  if (installed("prusa-slicer")) {
    EXPECT_EQ(countOf(said, "manifold = yes"), 2u) << said;
    EXPECT_EQ(countOf(said, "number_of_parts =  1\n"), 2u) << said;
    EXPECT_GT(fs::file_size(scratch / "out/parts.gcode"), 100000u);
    std::transform(said.begin(), said.end(), said.begin(), [](unsigned char c) { return char(std::tolower(c)); });
    EXPECT_EQ(said.find("warning"), std::string::npos) << said;
  }
}

TEST(LongPrintDemo, OfABall) {
  goesTheWholeWay("");
}

TEST(LongPrintDemo, OfABust) {
  const char* data = std::getenv("ARGIL_DATA");
  if (data == nullptr) GTEST_SKIP() << "ARGIL_DATA is not set: no model of another program";
  goesTheWholeWay((fs::path(data) / "mesh/nefertiti_lowres.obj").string());
}

// What it cannot do is said in a line, before anything is written.
TEST(PrintDemo, SaysWhatIsMissing) {
  const Scratch scratch;
  const std::string script = std::string(ARGIL_SOURCE_DIR) + "/scripts/print_demo.sh";
  const fs::path said = scratch / "said.txt", out = scratch / "out";
  const auto codeOf = [&](const std::string& words) {
    const int code = std::system(("ARGIL=" ARGIL_COMMAND " " + words + " 2>" + said.string()).c_str());
    EXPECT_EQ(countOf(slurp(said), "\n"), 1u) << slurp(said);
    return WEXITSTATUS(code);
  };
  EXPECT_EQ(codeOf(script + " nowhere.obj " + out.string()), 2);
  EXPECT_EQ(codeOf("ARGIL=/nowhere " + script + " '' " + out.string()), 2);
  EXPECT_EQ(codeOf(script + " '' " + out.string() + " more"), 2);
  EXPECT_FALSE(fs::exists(out));
}

}  // namespace
}  // namespace argil::tests
