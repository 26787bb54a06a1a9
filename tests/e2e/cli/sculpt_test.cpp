// The main job from the command line: clay in, strokes, files out; repeatable.

#include "tests/e2e/support/command.h"

#include <nlohmann/json.hpp>

namespace argil::tests {
namespace {

std::string script(const std::string& drive) {
  return R"({"argil":1,"units":"mm","setup":[{"voxel_mm":0.5},{"block":{"size_mm":[40,40,20],"round_mm":3}}],"strokes":[
    {"tool":"carve","radius_mm":3,"drive":")" +
         drive + R"(","path":[[0,-10,0,16],[0.5,-8,0,11],[1.5,8,2,10],[2,10,0,16]]},
    {"tool":"add","radius_mm":2,"drive":")" +
         drive + R"(","path":[[0,0,-10,14],[0.4,0,-9,10.5],[1,0,9,10.5],[1.4,0,10,14]]},
    {"tool":"smooth","radius_mm":4,"strength":0.6,"drive":")" +
         drive + R"(","path":[[0,-6,-6,15],[0.5,-5,-5,10],[1,5,5,10],[1.5,6,6,15]]}]})";
}

nlohmann::json sculpt(const Scratch& scratch, const std::string& name, const std::string& text,
                      std::vector<std::string> more = {}) {
  const fs::path file = scratch / (name + ".json"), report = scratch / (name + "-report.json");
  std::ofstream(file) << text;
  std::vector<std::string> arguments = {"sculpt", file.string(), "--report", report.string()};
  arguments.insert(arguments.end(), more.begin(), more.end());
  const Outcome o = argil(arguments);
  EXPECT_EQ(o.code, 0) << o.err;
  return nlohmann::json::parse(slurp(report));
}

class Drive : public testing::TestWithParam<const char*> {};

TEST_P(Drive, GivesAClosedSolidAndTheSameOneAgain) {
  const Scratch scratch;
  const nlohmann::json first = sculpt(scratch, "first", script(GetParam()),
                                      {"-o", (scratch / "a.stl").string(), "-o", (scratch / "a.ply").string()});
  EXPECT_TRUE(first["surface"]["closed"]);
  EXPECT_EQ(first["surface"]["boundary_edges"], 0);
  EXPECT_EQ(first["surface"]["non_manifold_edges"], 0);
  EXPECT_EQ(first["surface"]["non_manifold_vertices"], 0);
  EXPECT_GT(first["surface"]["volume_mm3"], 10000);
  EXPECT_LT(first["surface"]["volume_mm3"], 32000);
  EXPECT_EQ(first["strokes"], 3);
  const nlohmann::json second = sculpt(scratch, "second", script(GetParam()));
  EXPECT_EQ(first["clay"]["hash"], second["clay"]["hash"]);

  // What was written is what was reported.
  for (const char* file : {"a.stl", "a.ply"}) {
    const Outcome o = argil({"inspect", (scratch / file).string(), "--json"});
    ASSERT_EQ(o.code, 0) << o.err;
    const nlohmann::json inspected = nlohmann::json::parse(o.out);
    EXPECT_EQ(inspected["mesh"]["triangles"], first["surface"]["triangles"]) << file;
    EXPECT_TRUE(inspected["mesh"]["closed"]) << file;
    EXPECT_NEAR(inspected["mesh"]["volume_mm3"].get<double>(), first["surface"]["volume_mm3"].get<double>(), 1) << file;
  }
}
INSTANTIATE_TEST_SUITE_P(Sculpt, Drive, testing::Values("tip", "hand"));

TEST(Sculpt, ARecordingOfAHandGivesTheSameClay) {
  const Scratch scratch;
  const fs::path recorded = scratch / "recorded.json";
  const nlohmann::json hand = sculpt(scratch, "hand", script("hand"), {"--record", recorded.string()});
  ASSERT_GT(hand["servo"]["cutting"], 0);
  const nlohmann::json again = sculpt(scratch, "again", slurp(recorded));
  EXPECT_EQ(hand["clay"]["hash"], again["clay"]["hash"]);
}

TEST(Sculpt, LiveServoKeepsItsLimits) {
  const Scratch scratch;
  const nlohmann::json live = sculpt(scratch, "live", script("hand"), {"--live"});
  EXPECT_TRUE(live["surface"]["closed"]);
  EXPECT_GT(live["servo"]["cutting"], 0);
  EXPECT_EQ(live["servo"]["dropped"], 0);
  EXPECT_LE(live["servo"]["peak_force_n"].get<double>(), live["servo"]["force_limit_n"].get<double>());
  EXPECT_EQ(live["servo"]["fault"], "");
  EXPECT_TRUE(live["servo"].contains("bare_lateness"));
}

TEST(Sculpt, CtrlCLeavesNothingHalfWritten) {
  const Scratch scratch;
  const fs::path file = scratch / "long.json", out = scratch / "out.stl";
  std::ofstream(file) << script("hand");
  const Outcome o = argil({"sculpt", file.string(), "--live", "-o", out.string()}, 1500);
  EXPECT_EQ(o.code, 1) << o.err;
  EXPECT_NE(o.err.find("cancel"), std::string::npos) << o.err;
  EXPECT_FALSE(fs::exists(out));
}

TEST(Convert, UnitsAndClay) {
  const Scratch scratch;
  const fs::path file = scratch / "ball.json", ball = scratch / "ball.stl", inches = scratch / "inches.obj",
                 clay = scratch / "clay.ply";
  std::ofstream(file)
      << R"({"argil":1,"units":"mm","setup":[{"voxel_mm":0.25},{"sphere":{"radius_mm":10}}],"strokes":[]})";
  ASSERT_EQ(argil({"sculpt", file.string(), "-o", ball.string()}).code, 0);
  ASSERT_EQ(argil({"convert", ball.string(), inches.string(), "--units", "in"}).code, 0);
  const nlohmann::json scaled = nlohmann::json::parse(argil({"inspect", inches.string(), "--json"}).out);
  const double volume = 4.0 / 3 * M_PI * 1000;
  EXPECT_NEAR(scaled["mesh"]["volume_mm3"].get<double>() / (25.4 * 25.4 * 25.4), volume, 0.005 * volume);
  ASSERT_EQ(argil({"convert", ball.string(), clay.string(), "--voxel", "0.4"}).code, 0);
  const nlohmann::json voxelized = nlohmann::json::parse(argil({"inspect", clay.string(), "--json"}).out);
  EXPECT_TRUE(voxelized["mesh"]["closed"]);
  EXPECT_NEAR(voxelized["mesh"]["volume_mm3"].get<double>(), volume, 0.01 * volume);
}

TEST(Render, MakesAPictureOrSaysWhatToInstall) {
  const Scratch scratch;
  const fs::path file = scratch / "ball.json", ball = scratch / "ball.stl", picture = scratch / "ball.png";
  std::ofstream(file)
      << R"({"argil":1,"units":"mm","setup":[{"voxel_mm":0.5},{"sphere":{"radius_mm":10}}],"strokes":[]})";
  ASSERT_EQ(argil({"sculpt", file.string(), "-o", ball.string()}).code, 0);
  const Outcome o = argil({"render", ball.string(), "-o", picture.string(), "--size", "320x200"});
  if (o.code == 1 && o.err.find("mesa-vulkan-drivers") != std::string::npos) GTEST_SKIP() << o.err;
  ASSERT_EQ(o.code, 0) << o.err;
  const std::string png = slurp(picture);
  ASSERT_GT(png.size(), 1000u);
  EXPECT_EQ(png.substr(1, 3), "PNG");

  // A turntable: as many files as frames, all different, and looks from the command line.
  const Outcome turn = argil({"render",    ball.string(), "-o",        (scratch / "turn-%03d.png").string(),
                              "--size",    "160x120",     "--frames",  "3",
                              "--samples", "1",           "--shading", "matcap",
                              "--matcap",  "porcelain",   "--stereo",  "anaglyph",
                              "--section", "0,0,5,0,1,1", "--light",   "--depth-fade",
                              "0.5",       "--view",      "front"});
  ASSERT_EQ(turn.code, 0) << turn.err;
  const std::string first = slurp(scratch / "turn-000.png"), second = slurp(scratch / "turn-001.png"),
                    third = slurp(scratch / "turn-002.png");
  EXPECT_EQ(first.substr(1, 3), "PNG");
  EXPECT_NE(first, second);
  EXPECT_NE(second, third);
  EXPECT_FALSE(fs::exists(scratch / "turn-003.png"));
}

}  // namespace
}  // namespace argil::tests
