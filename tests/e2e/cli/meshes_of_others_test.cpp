// Meshes as others have them, on the command line: with pictures, crossing themselves, of hundreds of bodies.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <string>

#include "tests/e2e/support/command.h"
#include "tests/support/textured_samples.h"

namespace argil::tests {
namespace {

using nlohmann::json;
using samples::TexturedCube;
using testing::HasSubstr;

class MeshesOfOthers : public testing::Test {
 protected:
  void put(const std::string& name, const std::string& text) const {
    std::ofstream(folder / name, std::ios::binary) << text;
  }
  [[nodiscard]] std::string at(const std::string& name) const { return (folder / name).string(); }
  const Scratch folder;
};

TEST_F(MeshesOfOthers, PicturesBecomeColours) {
  const TexturedCube cube;
  put("board.png", samples::checkerPng());
  put("cube.mtl", "newmtl board\nmap_Kd board.png\n");
  put("cube.obj", cube.obj());
  const Outcome seen = argil({"inspect", at("cube.obj")});
  EXPECT_EQ(seen.code, 0) << seen.err;
  EXPECT_EQ(seen.out.find("picture"), std::string::npos) << seen.out;
  const Outcome plain = argil({"convert", at("cube.obj"), at("plain.ply")});
  EXPECT_EQ(plain.code, 0) << plain.err;
  EXPECT_THAT(plain.out, HasSubstr("Pictures become colours of vertices"));
  EXPECT_THAT(slurp(folder / "plain.ply").substr(0, 400), HasSubstr("property uchar red"));
  ASSERT_EQ(argil({"convert", at("cube.obj"), at("cube.argil"), "--voxel", "0.5"}).code, 0);
  EXPECT_THAT(argil({"inspect", at("cube.argil")}).out, HasSubstr("colour"));
  ASSERT_EQ(argil({"convert", at("cube.argil"), at("clay.ply")}).code, 0);
  EXPECT_THAT(slurp(folder / "clay.ply").substr(0, 400), HasSubstr("property uchar red"));
  // Without its picture the cube has no colour, and that is a note.
  fs::remove(folder / "board.png");
  const Outcome bare = argil({"convert", at("cube.obj"), at("bare.ply")});
  EXPECT_EQ(bare.code, 0) << bare.err;
  EXPECT_THAT(bare.out, HasSubstr("board.png"));
  EXPECT_EQ(slurp(folder / "bare.ply").substr(0, 400).find("property uchar red"), std::string::npos);
}

TEST_F(MeshesOfOthers, TrianglesThatCrossAreTold) {
  // A prism on a pentagram, wound around twice in the middle.
  std::ostringstream text;
  for (const int z : {0, 6})
    for (int i = 0; i < 5; ++i)
      text << "v " << 10 * std::cos(0.8 * M_PI * i) << ' ' << 10 * std::sin(0.8 * M_PI * i) << ' ' << z << '\n';
  text << "v 0 0 0\nv 0 0 6\n";
  for (int i = 1; i <= 5; ++i) {
    const int next = i % 5 + 1;
    text << "f " << i << ' ' << next << ' ' << next + 5 << "\nf " << i << ' ' << next + 5 << ' ' << i + 5 << "\nf 11 "
         << next << ' ' << i << "\nf 12 " << i + 5 << ' ' << next + 5 << '\n';
  }
  put("star.obj", text.str());
  const Outcome seen = argil({"inspect", at("star.obj"), "--voxel", "0.25"});
  EXPECT_EQ(seen.code, 0) << seen.err;
  EXPECT_THAT(seen.out, HasSubstr("crossing    15 pairs of triangles cross each other"));
  EXPECT_THAT(seen.out, HasSubstr("15 pairs of triangles cross each other; what they enclose"));
  EXPECT_EQ(seen.out.find("nothing to repair"), std::string::npos) << seen.out;
  EXPECT_EQ(seen.out.find("at this voxel size"), std::string::npos) << seen.out;
  EXPECT_EQ(json::parse(argil({"inspect", at("star.obj"), "--json"}).out)["mesh"]["crossing_pairs"], 15);
}

TEST_F(MeshesOfOthers, HundredsOfBodiesAreSplit) {
  std::ostringstream text;
  int first = 1;
  for (int i = 0; i < 144; ++i, first += 8) {
    for (int k = 0; k < 8; ++k)
      text << "v " << 4 * (i % 12) + 2 * (k & 1) << ' ' << 4 * (i / 12) + (k & 2) << ' ' << (k & 4) / 2 << '\n';
    for (const auto& [a, b, c] : samples::cube().triangles)
      text << "f " << first + int(a) << ' ' << first + int(b) << ' ' << first + int(c) << '\n';
  }
  put("cubes.obj", text.str());
  put("split.json", R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 0.25}, {"import": "cubes.obj"}],
"strokes": [{"operation": "split", "piece": "Clay"}]})");
  const Outcome done = argil({"sculpt", at("split.json"), "-o", at("split.argil"), "--report", at("report.json")});
  ASSERT_EQ(done.code, 0) << done.err;
  EXPECT_THAT(done.out, HasSubstr("was split into 144 parts"));
  EXPECT_THAT(argil({"inspect", at("split.argil")}).out, HasSubstr("144 pieces"));
}

}  // namespace
}  // namespace argil::tests
