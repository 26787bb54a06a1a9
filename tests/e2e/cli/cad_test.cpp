// `argil convert ... .step`: clay as a smooth solid; `--quads`: as few quads with pictures.

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <regex>
#include <sstream>
#include <string>

#include "tests/e2e/support/command.h"
#include "tests/support/step_samples.h"

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
  /// `words`: the output, then options.
  void expectRefused(const std::string& file, const std::vector<std::string>& words) {
    std::vector<std::string> all{"convert", file, (scratch_ / words[0]).string()};
    all.insert(all.end(), words.begin() + 1, words.end());
    const Outcome said = argil(all);
    EXPECT_EQ(said.code, 2) << said.out;
    EXPECT_EQ(std::count(said.err.begin(), said.err.end(), '\n'), 1) << said.err;
    EXPECT_FALSE(fs::exists(scratch_ / words[0]));
  }
  Scratch scratch_;
};

TEST_F(Cad, FacesOfPartsBecomeGuides) {
  std::ofstream(scratch_ / "block.step") << samples::stepOfBoredBlock({20, 30, 10}, 6);
  const std::string block = (scratch_ / "block.step").string();
  const Outcome said = argil({"convert", block, (scratch_ / "block.argil").string(), "--voxel", "0.5", "--guides"});
  if (said.err.find("is read by OpenCASCADE") != std::string::npos) GTEST_SKIP() << "this build has no OpenCASCADE";
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("7 guides of its faces."), std::string::npos) << said.out;
  const Outcome seen = argil({"inspect", (scratch_ / "block.argil").string()});
  EXPECT_NE(seen.out.find("7 guides"), std::string::npos) << seen.out;
  expectRefused(block, {"block.stl", "--guides"});
  expectRefused((scratch_ / "block.argil").string(), {"again.argil", "--guides"});
}

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

TEST_F(Cad, TheSameAsIges) {
  const std::string file = ring(), iges = (scratch_ / "out.igs").string();
  const Outcome said = argil({"convert", file, iges, "--faces", "200"});
  ASSERT_EQ(said.code, 0) << said.err;
  EXPECT_NE(said.out.find("out.igs: 2 solids written as IGES"), std::string::npos) << said.out;
  const Outcome seen = argil({"inspect", iges});
  if (seen.code == 0) {  // else there is no OpenCASCADE
    EXPECT_NE(seen.out.find("2 bodies"), std::string::npos) << seen.out;
    EXPECT_NE(seen.out.find("closed      yes"), std::string::npos) << seen.out;
  }
}

TEST_F(Cad, AsFewFacesAsAnErrorTakes) {
  const std::string file = ring(), step = (scratch_ / "out.step").string();
  const Outcome within = argil({"convert", file, step, "--error", "0.2"});
  ASSERT_EQ(within.code, 0) << within.err;
  EXPECT_NE(within.out.find("Ring: tried "), std::string::npos) << within.out;
  EXPECT_EQ(within.out.find("do not keep within"), std::string::npos) << within.out;
  const Outcome beyond = argil({"convert", file, step, "--error", "1e-5", "--faces", "60", "--overwrite"});
  ASSERT_EQ(beyond.code, 0) << beyond.err;
  EXPECT_TRUE(std::regex_search(beyond.out, std::regex("Egg: \\d+ faces do not keep within 1e-05 mm everywhere: "
                                                       "[^ ]+ mm at \\(")))
      << beyond.out;
}

TEST_F(Cad, BadWordsAreOneLineAndLeaveNothing) {
  const std::string file = ring();
  for (const std::vector<std::string>& words : std::vector<std::vector<std::string>>{{"out.step", "--faces", "3"},
                                                                                     {"out.step", "--faces", "x"},
                                                                                     {"out.stl", "--faces", "300"},
                                                                                     {"out.step", "--reduce", "0.5"},
                                                                                     {"out.step", "--error", "0"},
                                                                                     {"out.step", "--error", "-1"},
                                                                                     {"nowhere/out.step"},
                                                                                     {"out.step", "--for", "slicer"}})
    expectRefused(file, words);
}

TEST_F(Cad, QuadsComeWithPicturesOfTheClay) {
  const std::string file = ring();
  const Outcome said = argil({"convert", file, (scratch_ / "out.obj").string(), "--quads", "200", "--textures", "128"});
  ASSERT_EQ(said.code, 0) << said.err;
  const std::string text = slurp(scratch_ / "out.obj");
  size_t faces = 0;
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    if (line.rfind("f ", 0) != 0) continue;
    EXPECT_TRUE(std::regex_match(line, std::regex("f( [0-9]+/[0-9]+/[0-9]+){4}"))) << line;
    ++faces;
  }
  EXPECT_GT(faces, 300u);
  EXPECT_LE(faces, 400u);
  for (const char* each : {"out.mtl", "out_normal.png", "out_displacement.png", "out_2_normal.png"})
    EXPECT_TRUE(fs::exists(scratch_ / each)) << each;
  EXPECT_FALSE(fs::exists(scratch_ / "out_colour.png")) << "nothing is painted";
  std::smatch found;
  ASSERT_TRUE(std::regex_search(said.out, found,
                                std::regex("Ring: (\\d+) quads; ([^ ]+) mm RMS off the clay, ([^ ]+) at most; (\\d+) "
                                           "charts")))
      << said.out;
  EXPECT_LT(std::stod(found[2]), 0.3) << "edges of 5 mm on a tube of 7";
  EXPECT_LE(std::stoi(found[4]), 15);
  ASSERT_TRUE(std::regex_search(
      said.out, found,
      std::regex("Ring: (\\d+) vertices have more or fewer than four quads; scaled Jacobians \\(1 for a rectangle\\) "
                 "([^ ]+) in the mean, ([^ ]+) at least\\.")))
      << said.out;
  EXPECT_LT(std::stoi(found[1]), 60);
  EXPECT_GT(std::stod(found[2]), 0.85);
  EXPECT_GT(std::stod(found[3]), 0.2);
  const Outcome mirrored = argil({"convert", file, (scratch_ / "both.obj").string(), "--quads", "200", "--mirror"});
  ASSERT_EQ(mirrored.code, 0) << mirrored.err;
  EXPECT_NE(mirrored.out.find("; mirrored at x = "), std::string::npos) << mirrored.out;
  // What was written is the clay, and closed.
  const Outcome back = argil({"inspect", (scratch_ / "out.obj").string(), "--json"});
  EXPECT_EQ(back.code, 0) << back.err;
  const Outcome packed = argil(
      {"convert", file, (scratch_ / "out.glb").string(), "--for", "textured", "--quads", "60", "--textures", "64"});
  ASSERT_EQ(packed.code, 0) << packed.err;
  EXPECT_NE(slurp(scratch_ / "out.glb").find("normalTexture"), std::string::npos);
}

TEST_F(Cad, QuadsFollowGuidesAndLieCloserWhereItIsMasked) {
  std::ofstream script(scratch_ / "script.json");
  script << R"({"argil": 1, "units": "mm", "setup": [{"sphere": {"radius_mm": 15}}, {"voxel_mm": 0.5}, {"guides": [)"
         << R"({"guide": "lock_to_curve", "closed": true, "points": [)";
  for (int i = 0; i < 24; ++i)
    script << (i ? ", " : "") << "[" << 15 * std::cos(i * 0.2617994) << ", " << 15 * std::sin(i * 0.2617994) << ", 0]";
  script << R"(]}]}], "strokes": [{"tool": "mask", "radius_mm": 14, "path": [[0, 0, 0, 15], [1, 1, 0, 15]]}]})";
  script.close();
  const std::string file = (scratch_ / "ball.argil").string();
  const Outcome made = argil({"sculpt", (scratch_ / "script.json").string(), "-o", file});
  ASSERT_EQ(made.code, 0) << made.err;
  for (const std::string output : {"ball.obj", "ball.step"}) {
    const bool cad = output == "ball.step";
    const Outcome said = argil({"convert", file, (scratch_ / output).string(), cad ? "--faces" : "--quads", "150",
                                "--along-guides", "--mask-density", "4"});
    ASSERT_EQ(said.code, 0) << said.err;
    std::smatch found;
    ASSERT_TRUE(std::regex_search(said.out, found, std::regex("edges follow (\\d+) % of 1 closed curve, 94")))
        << said.out;
    EXPECT_GE(std::stoi(found[1]), 95);
    ASSERT_TRUE(std::regex_search(said.out, found, std::regex("where it is masked lie ([0-9.]+) times as many")))
        << said.out;
    EXPECT_GT(std::stod(found[1]), 1.8);
  }
  const Outcome plain = argil({"convert", file, (scratch_ / "plain.obj").string(), "--quads", "150"});
  EXPECT_EQ(plain.out.find("follow"), std::string::npos) << plain.out;
  EXPECT_EQ(plain.out.find("masked"), std::string::npos) << plain.out;
  expectRefused(file, {"out.stl", "--along-guides"});
  expectRefused(file, {"out.obj", "--quads", "150", "--mask-density", "0"});
  expectRefused(file, {"out.obj", "--quads", "150", "--mask-density", "17"});
  expectRefused(file, {"out.ply", "--mask-density", "2"});
}

TEST_F(Cad, BadWordsAboutQuadsAreOneLineAndLeaveNothing) {
  const std::string file = ring();
  for (const std::vector<std::string>& words :
       std::vector<std::vector<std::string>>{{"out.obj", "--quads", "3"},
                                             {"out.obj", "--quads", "1e9"},
                                             {"out.stl", "--quads", "300"},
                                             {"out.glb", "--textures", "512"},
                                             {"out.glb", "--mirror"},
                                             {"out.glb", "--quads", "300", "--textures", "4"},
                                             {"out.glb", "--quads", "300", "--draco"},
                                             {"out.obj", "--quads", "300", "--reduce", "0.5"},
                                             {"nowhere/out.obj", "--quads", "300"}})
    expectRefused(file, words);
}

}  // namespace
}  // namespace argil::tests
