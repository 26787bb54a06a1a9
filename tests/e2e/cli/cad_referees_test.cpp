// What other programs say of the solids that we write as STEP: OpenCASCADE's own check, FreeCAD's with
// self-intersections, and gmsh, whose triangles of it admesh looks at. Programs that are not installed are skipped with
// a word.

#include "tests/e2e/support/referees.h"

#include <cmath>
#include <map>
#include <regex>
#include <string>

#include <gtest/gtest.h>

namespace argil::tests {
namespace {

class CadReferees : public testing::TestWithParam<const char*> {
 protected:
  void SetUp() override {
    const std::string name = GetParam();
    std::string setup = "[]", steps = R"({"operation": "ring", "name": "Ring", "radius_mm": 20, "tube_mm": 7})";
    if (name == "block") setup = R"([{"block": {"size_mm": [40, 30, 20]}}, {"voxel_mm": 0.5}])", steps.clear();
    if (name.ends_with(".obj")) {
      const char* data = std::getenv("ARGIL_DATA");
      if (!data) GTEST_SKIP() << "ARGIL_DATA is not set: no model of another program";
      setup =
          R"([{"import": ")" + (fs::path(data) / "mesh" / name).string() + R"("}, {"fit_mm": 100}, {"voxel_mm": 0.5}])";
      steps.clear();
    }
    spill(scratch / "script.json",
          R"({"argil": 1, "units": "mm", "setup": )" + setup + R"(, "strokes": [)" + steps + "]}");
    Outcome made = argil({"sculpt", (scratch / "script.json").string(), "-o", (scratch / "clay.argil").string()});
    ASSERT_EQ(made.code, 0) << made.err;
    made = argil({"convert", (scratch / "clay.argil").string(), step.string(), "--faces", "300"});
    ASSERT_EQ(made.code, 0) << made.err;
    std::printf("%s", made.out.c_str());
    toldOfFolds = made.out.find("fold over") != std::string::npos;
    const Outcome inspected = argil({"inspect", (scratch / "clay.argil").string()});
    std::smatch found;
    ASSERT_TRUE(std::regex_search(inspected.out, found, std::regex("volume +([0-9.]+) mm"))) << inspected.out;
    volume = name == "block" ? 40 * 30 * 20 : std::stod(found[1]);  // what is told of it cuts off its edges
  }
  void spill(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }
  double numberAfter(const std::string& text, const std::string& words) {
    std::smatch found;
    if (std::regex_search(text, found, std::regex(words + " *:? *([-+0-9.e]+)"))) return std::stod(found[1]);
    ADD_FAILURE() << words << " is not in\n" << text;
    return 0;
  }

  void readText();
  void askOpenCascade();
  void askFreeCad();
  void askGmsh();

  Scratch scratch;
  fs::path step = scratch / "clay.step";
  double volume = 0;
  bool toldOfFolds = false;
};

void CadReferees::readText() {
  std::string text = slurp(step);
  std::erase(text, '\n');
  std::map<std::string, int> uses;
  const std::regex edge("#([0-9]+)=EDGE_CURVE\\("), use("ORIENTED_EDGE\\('[^']*',\\*,\\*,#([0-9]+),");
  for (std::sregex_iterator it(text.begin(), text.end(), edge), end; it != end; ++it) uses[(*it)[1]];
  for (std::sregex_iterator it(text.begin(), text.end(), use), end; it != end; ++it) ++uses[(*it)[1]];
  ASSERT_GT(uses.size(), 100u);
  for (const auto& [name, count] : uses) EXPECT_EQ(count, 2) << "edge #" << name;
}

void CadReferees::askOpenCascade() {
  if (!installed("occt-draw-7.6")) return;
  spill(scratch / "t.tcl",
        "pload MODELING XDE\nstepread clay.step a *\nputs [checkshape a_1]\nputs [nbshapes a_1]\nputs [tolerance a_1]\n"
        "puts [vprops a_1 1e-4]\n");
  const std::string said = outputOf("occt-draw-7.6 -b -f t.tcl", scratch / "");
  EXPECT_NE(said.find("This shape seems to be valid"), std::string::npos) << said;
  EXPECT_EQ(numberAfter(said, "SOLID"), 1);
  EXPECT_LE(numberAfter(said, "Tolerance MAX="), 1.01e-7);
  EXPECT_NEAR(numberAfter(said, "Mass") / volume, 1, 2e-3);
}

void CadReferees::askFreeCad() {
  if (!installed("freecadcmd")) return;
  spill(scratch / "t.py",
        "import Part\ns = Part.Shape()\ns.read('clay.step')\nprint('valid', s.isValid())\nprint('check', "
        "s.check(True))\n");
  const std::string said = outputOf("freecadcmd t.py </dev/null", scratch / "");
  EXPECT_NE(said.find("valid True"), std::string::npos) << said;
  // Where we tell of folds it may find them, too.
  if (!toldOfFolds) {
    EXPECT_NE(said.find("check None"), std::string::npos) << said;
  }
}

void CadReferees::askGmsh() {
  if (!installed("gmsh") || !installed("admesh")) return;
  // By curvature: sizes fall to nothing where a corner of a face is half a turn, and it goes on for ever where one
  // folds.
  (void)outputOf("{ timeout 300 gmsh -2 clay.step -format stl -clcurv 24 -o mesh.stl || [ $? = 124 ]; }", scratch / "");
  if (toldOfFolds && !fs::exists(scratch / "mesh.stl")) {
    std::printf("gmsh is not done in 300 s with faces that fold\n");
    return;
  }
  const std::string said = outputOf("admesh mesh.stl", scratch / "");
  EXPECT_EQ(numberAfter(said, "Total disconnected facets"), 0);
  EXPECT_EQ(numberAfter(said, "Number of parts"), 1);
  EXPECT_EQ(numberAfter(said, "Degenerate facets"), 0);
  EXPECT_NEAR(numberAfter(said, "Volume") / volume, 1, 1e-2);
}

TEST_P(CadReferees, FindNothing) {
  readText();
  askOpenCascade();
  askFreeCad();
  askGmsh();
}

INSTANTIATE_TEST_SUITE_P(LongClay, CadReferees, testing::Values("ring", "block", "fandisk.obj"));

}  // namespace
}  // namespace argil::tests
