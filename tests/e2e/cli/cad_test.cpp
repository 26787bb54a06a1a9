// `argil convert ... .step`: clay as a smooth solid.

#include <gtest/gtest.h>

#include <fstream>
#include <regex>
#include <string>

#include "tests/e2e/support/command.h"

namespace argil::tests {
namespace {

class Cad : public ::testing::Test {
 protected:
  std::string ring() {
    std::ofstream(scratch_ / "script.json")
        << R"({"argil": 1, "units": "mm", "setup": [], "strokes": [)"
        << R"({"operation": "ring", "name": "Ring", "voxel_mm": 0.5, "radius_mm": 20, "tube_mm": 7}, )"
        << R"({"operation": "ellipsoid", "name": "Egg", "centre_mm": [60, 0, 0], "voxel_mm": 0.5}]})";
    const fs::path file = scratch_ / "clay.argil";
    const Outcome o = argil({"sculpt", (scratch_ / "script.json").string(), "-o", file.string()});
    EXPECT_EQ(o.code, 0) << o.err;
    return file.string();
  }
  Scratch scratch_;
};

TEST_F(Cad, EachPieceIsASolidAndItIsSaidHowFarItLiesOff) {
  const std::string file = ring(), step = (scratch_ / "out.step").string();
  const Outcome said = argil({"convert", file, step, "--faces", "200"});
  ASSERT_EQ(said.code, 0) << said.err;
  const std::string text = slurp(step);
  const auto count = [&](const std::string& what) {
    size_t n = 0;
    for (size_t at = text.find(what); at != std::string::npos; at = text.find(what, at + 1)) ++n;
    return n;
  };
  EXPECT_EQ(count("=MANIFOLD_SOLID_BREP('Ring'"), 1u);
  EXPECT_EQ(count("=MANIFOLD_SOLID_BREP('Egg'"), 1u);
  EXPECT_EQ(count("=ORIENTED_EDGE("), 2 * count("=EDGE_CURVE("));
  EXPECT_GT(count("=ADVANCED_FACE("), 150u);
  EXPECT_LE(count("=ADVANCED_FACE("), 400u);
  std::smatch found;
  ASSERT_TRUE(
      std::regex_search(said.out, found, std::regex("Ring: (\\d+) smooth faces; from them to the clay ([^ ]+) mm RMS")))
      << said.out;
  EXPECT_LE(std::stoi(found[1]), 200);
  EXPECT_LT(std::stod(found[2]), 0.02);
}

TEST_F(Cad, BadWordsAreOneLineAndLeaveNothing) {
  const std::string file = ring();
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{{"out.step", "--faces", "3"},
                                                                                     {"out.step", "--faces", "x"},
                                                                                     {"out.stl", "--faces", "300"},
                                                                                     {"out.step", "--reduce", "0.5"},
                                                                                     {"nowhere/out.step"},
                                                                                     {"out.step", "--for", "slicer"}}) {
    std::vector<std::string> all{"convert", file, (scratch_ / words[0]).string()};
    all.insert(all.end(), words.begin() + 1, words.end());
    const Outcome said = argil(all);
    EXPECT_EQ(said.code, 2) << said.out;
    EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1) << said.err;
    EXPECT_FALSE(fs::exists(scratch_ / words[0]));
  }
}

}  // namespace
}  // namespace argil::tests
