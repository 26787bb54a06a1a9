// Models come in upright, on the ground and at the size that is chosen, by options of the command line.

#include <cstdint>
#include <map>
#include <nlohmann/json.hpp>
#include <tuple>

#include "tests/e2e/support/command.h"

namespace argil::tests {
namespace {

using Json = nlohmann::json;

// The surface of a CT volume in mm, as a binary STL: the faces between voxels above and below the threshold.
void writeCtStl(const fs::path& volume, const fs::path& stl) {
  constexpr int kX = 103, kY = 94, kZ = 161, kThreshold = 500;  // As tooth.nhdr has it: big endian, 1 mm.
  const std::string raw = slurp(volume);
  ASSERT_EQ(raw.size(), size_t{2} * kX * kY * kZ);
  const auto inside = [&](int x, int y, int z) {
    if (x < 0 || y < 0 || z < 0 || x >= kX || y >= kY || z >= kZ) return false;
    const size_t at = 2 * ((size_t(z) * kY + size_t(y)) * kX + size_t(x));
    return (uint8_t(raw[at]) << 8 | uint8_t(raw[at + 1])) > kThreshold;
  };
  std::string faces;
  uint32_t count = 0;
  const auto triangle = [&](const std::array<std::array<float, 3>, 3>& corners) {
    const std::array<float, 3> none{};
    faces.append(reinterpret_cast<const char*>(none.data()), 12);
    for (const auto& corner : corners) faces.append(reinterpret_cast<const char*>(corner.data()), 12);
    faces.append(2, '\0');
    ++count;
  };
  for (int z = 0; z < kZ; ++z)
    for (int y = 0; y < kY; ++y)
      for (int x = 0; x < kX; ++x)
        for (int axis = 0; inside(x, y, z) && axis < 3; ++axis)
          for (const int side : {0, 1}) {
            const int step = side == 0 ? -1 : 1;
            if (inside(x + (axis == 0) * step, y + (axis == 1) * step, z + (axis == 2) * step)) continue;
            const int u = (axis + 1) % 3, v = (axis + 2) % 3;
            const auto corner = [&](int du, int dv) {
              std::array<float, 3> p{float(x), float(y), float(z)};
              p[size_t(axis)] += float(side);
              p[size_t(u)] += float(du);
              p[size_t(v)] += float(dv);
              return p;
            };
            const auto a = corner(0, 0), b = corner(1, 0), c = corner(1, 1), d = corner(0, 1);
            triangle(side == 1 ? std::array{a, b, c} : std::array{a, c, b});
            triangle(side == 1 ? std::array{a, c, d} : std::array{a, d, c});
          }
  std::ofstream out(stl, std::ios::binary);
  out << std::string(80, ' ');
  out.write(reinterpret_cast<const char*>(&count), 4);
  out << faces;
}

struct Box {
  std::array<double, 3> low{}, high{};
  [[nodiscard]] double size(size_t axis) const { return high[axis] - low[axis]; }
};
Box boxOf(const fs::path& file) {
  const Outcome o = argil({"inspect", file.string(), "--json"});
  EXPECT_EQ(o.code, 0) << o.err;
  const Json json = Json::parse(o.out, nullptr, false);
  Box box;
  if (!json.is_object()) return box;
  box.low = json["mesh"]["low_mm"].get<std::array<double, 3>>();
  box.high = json["mesh"]["high_mm"].get<std::array<double, 3>>();
  return box;
}

class Place : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!realData()) GTEST_SKIP() << "ARGIL_DATA is not set";
    data = realData();
  }
  // Converted with these options: stands on the ground over the middle.
  Box converted(const fs::path& input, std::vector<std::string> options) {
    const fs::path out = scratch / "out.stl";
    fs::remove(out);
    std::vector<std::string> words{"convert", input.string(), out.string(), "--ground"};
    words.insert(words.end(), options.begin(), options.end());
    const Outcome o = argil(words);
    EXPECT_EQ(o.code, 0) << o.err;
    said = o.out;
    const Box box = boxOf(out);
    EXPECT_NEAR(box.low[2], 0, 1e-3) << "not on the ground";
    for (const size_t axis : {0, 1}) EXPECT_NEAR(box.low[axis] + box.high[axis], 0, 1e-2) << "not over the middle";
    return box;
  }
  fs::path data;
  Scratch scratch;
  std::string said;
};

// The bust is y up in its file, 239 × 495 × 363 units.
TEST_F(Place, ABustStandsUprightAtTheHeightThatIsSet) {
  const Box box = converted(data / "mesh/nefertiti_lowres.obj", {"--units", "auto", "--up", "auto", "--height", "200"});
  EXPECT_NEAR(box.size(2), 200, 0.01);
  EXPECT_NEAR(box.size(0), 200 * 239.0 / 495, 2);
  EXPECT_NEAR(box.size(1), 200 * 363.0 / 495, 2);
  EXPECT_NE(said.find("y up"), std::string::npos) << said;
  // The same bust as STL: the convention of the format says z, its flat base says y.
  const fs::path stl = scratch / "bust.stl";
  ASSERT_EQ(argil({"convert", (data / "mesh/nefertiti_lowres.obj").string(), stl.string()}).code, 0);
  EXPECT_NEAR(converted(stl, {"--units", "auto", "--up", "auto", "--height", "200"}).size(0), 200 * 239.0 / 495, 2);
}

TEST_F(Place, ASurfaceOfACtScanStaysInMillimetresAndUpright) {
  const fs::path stl = scratch / "tooth.stl";
  ASSERT_NO_FATAL_FAILURE(writeCtStl(data / "volume/tooth.raw", stl));
  const Box lies = boxOf(stl), stands = converted(stl, {"--units", "auto", "--up", "auto"});
  for (const size_t axis : {0, 1, 2}) EXPECT_NEAR(stands.size(axis), lies.size(axis), 1e-3) << axis;
  EXPECT_NE(said.find("read as mm, z up"), std::string::npos) << said;
}

// 5 × 2.5 × 1.375 inches, as its STEP file says.
TEST_F(Place, APartInInchesIsKnownByItsSize) {
  const Box box = converted(data / "mesh/featuretype.STL", {"--units", "auto", "--up", "auto"});
  EXPECT_NEAR(box.size(0), 127, 0.01);
  EXPECT_NEAR(box.size(1), 63.5, 0.01);
  EXPECT_NEAR(box.size(2), 34.925, 0.01);
}

TEST_F(Place, AScanInMetresIsKnownByItsSize) {
  const Box box = converted(data / "mesh/stanford-bunny.obj", {"--units", "auto", "--up", "auto"});
  EXPECT_NEAR(box.size(2), 154, 1) << "the height of the bunny is along y in its file";
  EXPECT_NEAR(box.size(0), 156, 1);
}

// Up axes of real models, as their makers have them.
TEST_F(Place, TheUpAxisIsGuessedByTheShapeAndTheKindOfFile) {
  const std::map<std::string, std::string> known = {
      {"mesh/armadillo_29k.obj", "y up"},     {"mesh/koala_100k.obj", "y up"}, {"mesh/spot.obj", "y up"},
      {"mesh/suzanne.obj", "y up"},           {"mesh/teapot.obj", "y up"},     {"mesh/goblet_vase.stl", "z up"},
      {"mesh/penguin_quad_cage.obj", "y up"}, {"mesh/ADIS16480.STL", "z up"},  {"3mf/box.3mf", "z up"},
  };
  for (const auto& [name, up] : known) {
    const Outcome o = argil({"inspect", (data / name).string(), "--up", "auto"});
    EXPECT_EQ(o.code, 0) << o.err;
    EXPECT_NE(o.out.find(up), std::string::npos) << name << ": " << o.out;
  }
}

TEST_F(Place, OtherVerbsTakeTheSameOptionsAndBadOnesAreOneLine) {
  const std::string bust = (data / "mesh/spot.obj").string();
  const fs::path clay = scratch / "spot.argil", picture = scratch / "spot.png";
  const Outcome o = argil({"convert", bust, clay.string(), "--up", "y", "--height", "80", "--ground", "--voxel", "2"});
  EXPECT_EQ(o.code, 0) << o.err;
  const Json json = Json::parse(argil({"inspect", clay.string(), "--json"}).out, nullptr, false);
  ASSERT_TRUE(json.is_object());
  const Json& skin = json["pieces"][0]["surface"];
  EXPECT_NEAR(skin["low_mm"][2].get<double>(), 0, 1) << "a voxel of 2 mm rounds hooves";
  EXPECT_NEAR(skin["high_mm"][2].get<double>(), 80, 2) << "and horns";
  // A picture takes units and axis too.
  const Outcome drawn =
      argil({"render", bust, "-o", picture.string(), "--units", "in", "--up", "y", "--voxel", "1", "--size", "64x64"});
  EXPECT_EQ(drawn.code, 0) << drawn.err;
  EXPECT_NE(drawn.out.find("read as inches"), std::string::npos) << drawn.out;
  using Bad = std::tuple<std::vector<std::string>, std::string>;
  for (const auto& [options, word] :
       {Bad{{"--units", "mile"}, "mile"}, Bad{{"--up", "w"}, "-x"}, Bad{{"--height", "0"}, "height"},
        Bad{{"--height", "nan"}, "height"}, Bad{{"--height", "-5"}, "height"}}) {
    for (const std::string verb : {"convert", "inspect", "render"}) {
      std::vector<std::string> words{verb, bust};
      if (verb == "convert") words.push_back((scratch / "bad.stl").string());
      if (verb == "render") words.insert(words.end(), {"-o", (scratch / "bad.png").string()});
      words.insert(words.end(), options.begin(), options.end());
      const Outcome bad = argil(words);
      EXPECT_EQ(bad.code, 2) << verb << " " << options[0] << " " << options[1] << ": " << bad.out;
      EXPECT_NE(bad.err.find(word), std::string::npos) << bad.err;
      EXPECT_EQ(std::count(bad.err.begin(), bad.err.end(), '\n'), 1) << bad.err;
    }
  }
  const Outcome placed = argil({"render", clay.string(), "-o", picture.string(), "--up", "y"});
  EXPECT_EQ(placed.code, 2);
  EXPECT_NE(placed.err.find("--up"), std::string::npos) << placed.err;
}

// A stroke that meets nothing is not told as one that did its work.
TEST(Sculpt, SaysWhichStrokesChangedNothing) {
  Scratch scratch;
  const fs::path script = scratch / "miss.json", report = scratch / "report.json";
  std::ofstream(script) << R"({"argil":1,"units":"mm","setup":[{"voxel_mm":0.5},{"sphere":{"radius_mm":8}}],"strokes":[
    {"tool":"carve","radius_mm":3,"path":[[0,-6,0,8],[1,6,0,8]]},{"tool":"carve","radius_mm":3,"path":[[0,-6,0,80],[1,6,0,80]]},
    {"tool":"carve","radius_mm":3,"drive":"hand","path":[[0,-6,0,40],[0.5,6,0,40]]}]})";
  const Outcome o = argil({"sculpt", script.string(), "--report", report.string()});
  EXPECT_EQ(o.code, 0) << o.err;
  EXPECT_EQ(o.out.find("strokes[0]"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("strokes[1]: Carve changed nothing"), std::string::npos) << o.out;
  EXPECT_NE(o.out.find("strokes[2]: Carve changed nothing"), std::string::npos) << o.out;
  EXPECT_EQ(Json::parse(slurp(report))["unchanged_strokes"], 2);
}

}  // namespace
}  // namespace argil::tests
