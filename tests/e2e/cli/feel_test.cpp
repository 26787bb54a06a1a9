// argil feel: forces along a recorded path, by any contact; nothing is left when something is wrong.

#include "tests/e2e/support/command.h"

#include <algorithm>
#include <cmath>
#include <regex>

#include "haptics/threads/sample_ring.h"

namespace argil::tests {
namespace {

// A ball of radius 10 mm, and a hand that comes down on its top, 1 mm deep with a ball of 2 mm, and glides 45° over it.
class Feel : public testing::Test {
 protected:
  void SetUp() override {
    std::ofstream(scratch_ / "ball.json")
        << R"({"argil":1,"units":"mm","setup":[{"voxel_mm":0.5},{"sphere":{"radius_mm":10}}],"strokes":[]})";
    ASSERT_EQ(argil({"sculpt", (scratch_ / "ball.json").string(), "-o", mesh()}).code, 0);
    std::ofstream path(scratch_ / "path.csv");
    path << "t_s,x_mm,y_mm,z_mm\n0,0,0,15\n0.5,0,0,11\n";
    for (int i = 1; i <= 45; ++i)
      path << 0.5 + 0.02 * i << ',' << 11 * std::sin(i * M_PI / 180) << ",0," << 11 * std::cos(i * M_PI / 180) << '\n';
  }
  [[nodiscard]] std::string mesh() const { return (scratch_ / "ball.stl").string(); }
  [[nodiscard]] std::string path() const { return (scratch_ / "path.csv").string(); }
  [[nodiscard]] std::string csv() const { return (scratch_ / "felt.csv").string(); }
  Outcome feel(std::vector<std::string> more) const {
    std::vector<std::string> call = {"feel", mesh(),     "--path", path(),       "--voxel",
                                     "0.5",  "--radius", "2",      "--overwrite"};
    call.insert(call.end(), more.begin(), more.end());
    return argil(call);
  }
  // Rows as numbers, by the header's order.
  [[nodiscard]] std::vector<std::vector<double>> rows() const {
    std::istringstream in(slurp(csv()));
    std::vector<std::vector<double>> all;
    std::string line;
    std::getline(in, line);
    EXPECT_EQ(line,
              "t_s,x_mm,y_mm,z_mm,fx_n,fy_n,fz_n,proxy_x_mm,proxy_y_mm,proxy_z_mm,planes,depth_mm,flags,compute_us");
    while (std::getline(in, line)) {
      std::istringstream cells(line);
      all.emplace_back();
      for (std::string cell; std::getline(cells, cell, ',');) all.back().push_back(std::stod(cell));
      EXPECT_EQ(all.back().size(), 14u);
    }
    return all;
  }
  const Scratch scratch_;
};

TEST_F(Feel, TheProxySlidesOverABall) {
  const Outcome o = feel({"-o", csv()});
  ASSERT_EQ(o.code, 0) << o.err;
  EXPECT_NE(o.out.find("proxy"), std::string::npos);
  const auto all = rows();
  ASSERT_EQ(all.size(), 1401u);
  for (size_t i = 0; i < all.size(); ++i) {
    const auto& r = all[i];
    EXPECT_NEAR(r[0], double(i) * 1e-3, 1e-9);
    const double height = std::hypot(r[1], r[3]);
    if (height > 12.2) {
      EXPECT_EQ(std::hypot(r[4], r[5], r[6]), 0) << i;
    }
    if (i < 550) continue;
    EXPECT_NEAR(std::hypot(r[4], r[6]), 12 - height, 0.06) << i;  // 1 N/mm
    EXPECT_NEAR(std::hypot(r[7], r[8], r[9]), 12, 0.06) << i;     // The proxy's centre
    EXPECT_GT((r[4] * r[1] + r[6] * r[3]) / std::hypot(r[4], r[5], r[6]) / height, 0.995) << i;
    EXPECT_GE(r[10], 1) << i;
  }
}

// Of a texture of ±0.1 mm, one ridge a millimetre, the clay and the mesh itself give the same force.
TEST_F(Feel, TexturesOnClayAndOnTheMeshAsItIs) {
  std::vector<double> felt[3];
  const std::vector<std::string> ways[3] = {{"--texture", "ridges:1:0.1"}, {"--texture", "ridges:1:0.1", "--part"}, {}};
  for (int way = 0; way < 3; ++way) {
    std::vector<std::string> more = ways[way];
    more.insert(more.end(), {"-o", csv()});
    const Outcome o = feel(more);
    ASSERT_EQ(o.code, 0) << o.err;
    const auto all = rows();
    for (size_t i = 600; i < all.size(); ++i) felt[way].push_back(std::hypot(all[i][4], all[i][5], all[i][6]));
  }
  double apart = 0, low = 1e9, high = 0;
  for (size_t i = 0; i < felt[0].size(); ++i) {
    apart = std::max(apart, std::abs(felt[0][i] - felt[1][i]));
    low = std::min(low, felt[2][i] - felt[0][i]);
    high = std::max(high, felt[2][i] - felt[0][i]);
  }
  EXPECT_LT(apart, 0.08);
  EXPECT_GT(high, 0.12);
  EXPECT_LT(low, 0.01);
}

TEST_F(Feel, EveryContactAndAFreeHand) {
  for (const char* contact : {"proxy", "god-object", "penalty"}) {
    const Outcome o = feel({"--contact", contact, "--move", "0,0,-2", "-o", csv()});
    ASSERT_EQ(o.code, 0) << o.err;
    const auto all = rows();
    double peak = 0, jumps2 = 0;
    size_t jumps = 0;
    for (size_t i = 0; i < all.size(); ++i) {
      const auto& r = all[i];
      peak = std::max(peak, std::hypot(r[4], r[5], r[6]));
      if (i == 0 || !(uint32_t(r[12]) & uint32_t(all[i - 1][12]) & haptics::kTouching)) continue;
      const auto& b = all[i - 1];
      const double jump = std::hypot(r[4] - b[4], r[5] - b[5], r[6] - b[6]);
      jumps2 += jump * jump;
      ++jumps;
    }
    EXPECT_GT(peak, 0.5) << contact;
    ASSERT_GT(jumps, 100u);
    std::smatch told;
    ASSERT_TRUE(std::regex_search(o.out, told, std::regex("tick to tick +([0-9.]+) % of it RMS"))) << o.out;
    EXPECT_NEAR(std::stod(told[1]), 100 / peak * std::sqrt(jumps2 / double(jumps)), 2e-3);
  }
  const Outcome o = feel({"--free", "--device", "falcon", "-o", csv()});
  ASSERT_EQ(o.code, 0) << o.err;
  // The hand gives way: it is not where the path is.
  EXPECT_GT(rows()[520][3], 11.1);
  for (const auto& row : rows()) EXPECT_EQ(uint32_t(row[12]) & haptics::kQueueFull, 0u) << "nobody asked for samples";
}

TEST_F(Feel, TheSameTwiceButForTheTimes) {
  const auto once = [&] {
    EXPECT_EQ(feel({"--friction", "0.4", "--stiffness", "0.8", "-o", csv()}).code, 0);
    auto all = rows();
    for (auto& r : all) r[13] = 0;
    return all;
  };
  EXPECT_EQ(once(), once());
}

TEST_F(Feel, PathsOfOtherUnitsAndPlaces) {
  std::ofstream(scratch_ / "path.csv")
      << "demo,time,x,y,z\n1,0,0.3,0,5\n2,7,0.31,0,5\n2,7.5,0.312,0.001,5.02\n2,8,0.315,0,5\n";
  const Outcome o =
      feel({"--units", "m", "--rows", "demo=2", "--fit", "--onto", "0,0,-1", "--press", "0.5", "-o", csv()});
  ASSERT_EQ(o.code, 0) << o.err;
  double deepest = 0;
  size_t touching = 0;
  for (const auto& r : rows()) {
    deepest = std::max(deepest, r[11]);
    touching += r[10] > 0;
  }
  EXPECT_GT(touching, 500u);
  EXPECT_NEAR(deepest, 0.5, 0.2);
}

TEST_F(Feel, WhatIsWrongIsOneLineAndNothingIsLeft) {
  std::ofstream(scratch_ / "bad.csv") << "t_s,x_mm,y_mm,z_mm\n0,0,0,nan\n";
  std::ofstream(scratch_ / "noise.png") << "not a picture";
  const std::string bad = (scratch_ / "bad.csv").string(), image = (scratch_ / "noise.png").string();
  const std::vector<std::pair<std::vector<std::string>, std::string>> calls = {
      {{"--contact", "fancy"}, "fancy"},
      {{"--device", "teapot"}, "teapot"},
      {{"--part", "--contact", "penalty"}, "part"},
      {{"--radius", "0"}, "radius"},
      {{"--stiffness", "-1"}, "stiffness"},
      {{"--friction", "9"}, "friction"},
      {{"--texture", "velvet"}, "texture"},
      {{"--texture", "ridges:0:1"}, "texture"},
      {{"--texture", "ridges:1:x"}, "texture"},
      {{"--texture", "image:" + image + ":0.1:0.1"}, "noise.png"},
      {{"--path", bad}, "bad.csv"},
      {{"--path", (scratch_ / "missing.csv").string()}, "missing.csv"},
      {{"--path", bad, "--units", "parsec"}, "parsec"},
      {{"--rate", "1"}, "rate"},
      {{"--onto", "0,0"}, "onto"},
      {{"--onto", "0,0,0"}, "onto"},
      {{"--move", "1,2,inf"}, "move"},
      {{"--size", "0"}, "size"},
  };
  for (const auto& [more, names] : calls) {
    std::vector<std::string> call = {"feel", mesh(), "--voxel", "0.5", "-o", csv()};
    if (std::find(more.begin(), more.end(), "--path") == more.end()) call.insert(call.end(), {"--path", path()});
    call.insert(call.end(), more.begin(), more.end());
    const Outcome o = argil(call);
    EXPECT_EQ(o.code, 2) << names << o.err;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << o.err;
    EXPECT_NE(o.err.find(names), std::string::npos) << o.err;
    for (const auto& entry : fs::directory_iterator(scratch_.path()))
      EXPECT_EQ(entry.path().string().find("felt"), std::string::npos) << entry.path();
  }
}

}  // namespace
}  // namespace argil::tests
