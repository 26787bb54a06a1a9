// The table of tools as a person at the command line meets it.

#include "tests/e2e/support/command.h"

#include <nlohmann/json.hpp>
#include <set>

namespace argil::tests {
namespace {

void write(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

std::vector<std::string> lines(const std::string& text) {
  std::vector<std::string> all;
  std::istringstream stream(text);
  for (std::string line; std::getline(stream, line);) all.push_back(line);
  return all;
}

TEST(Tools, AreListedWithWhatCanBeSet) {
  const Outcome ids = argil({"tools", "--ids"}), json = argil({"tools", "--json"}), text = argil({"tools"});
  ASSERT_EQ(ids.code, 0) << ids.err;
  const auto rows = nlohmann::json::parse(json.out);
  std::set<std::string> listed;
  for (const auto& row : rows) {
    listed.insert(row.at("id").get<std::string>());
    EXPECT_FALSE(row.at("help").get<std::string>().empty());
    EXPECT_GE(row.at("parameters").size(), 1u);
  }
  for (const std::string& id : lines(ids.out)) {
    EXPECT_TRUE(listed.contains(id)) << id;
    EXPECT_NE(text.out.find(id), std::string::npos) << id;
  }
  EXPECT_GE(listed.size(), 30u);
  const Outcome wrong = argil({"tools", "--demo", "axe"});
  EXPECT_EQ(wrong.code, 2);
  EXPECT_EQ(lines(wrong.err).size(), 1u) << wrong.err;
}

// The scene of each is a script that runs and leaves a closed solid that the tool has changed.
TEST(Tools, ScenesOfEachRun) {
  const Scratch scratch;
  std::string pgm = "P5 16 16 255\n";
  for (int i = 0; i < 256; ++i) pgm += char((i % 16 - 8) * (i / 16 - 8) > 0 ? 255 : 0);
  write(scratch / "tile.pgm", pgm);
  write(scratch / "ball.json",
        R"({"argil":1,"units":"mm","setup":[{"voxel_mm":0.5},{"sphere":{"radius_mm":5}}],"strokes":[]})");
  ASSERT_EQ(argil({"sculpt", (scratch / "ball.json").string(), "-o", (scratch / "tile.stl").string()}).code, 0);
  for (const std::string& id : lines(argil({"tools", "--ids"}).out)) {
    const fs::path script = scratch / (id + ".json"), out = scratch / (id + ".argil");
    write(script, argil({"tools", "--demo", id}).out);
    const Outcome made = argil({"sculpt", script.string(), "-o", out.string(), "--overwrite"});
    ASSERT_EQ(made.code, 0) << id << ": " << made.err;
    const Outcome seen = argil({"inspect", out.string()});
    EXPECT_NE(seen.out.find("closed      yes"), std::string::npos) << id << ": " << seen.out;
    // Two strokes made the bump and the furrow, the tool made at least one step more.
    EXPECT_EQ(seen.out.find("2 steps of history"), std::string::npos) << id << " did nothing: " << seen.out;
  }
}

TEST(Tools, WhatIsWrongWithOneIsOneLine) {
  const Scratch scratch;
  const auto complaint = [&](const std::string& stroke) {
    write(scratch / "w.json", R"({"argil":1,"units":"mm","setup":[{"sphere":{"radius_mm":8}}],"strokes":[{)" + stroke +
                                  R"(,"path":[[0,0,0,8]]}]})");
    const Outcome outcome = argil({"sculpt", (scratch / "w.json").string(), "-o", (scratch / "w.stl").string()});
    EXPECT_EQ(outcome.code, 2) << stroke;
    EXPECT_EQ(lines(outcome.err).size(), 1u) << outcome.err;
    EXPECT_FALSE(fs::exists(scratch / "w.stl"));
    return outcome.err;
  };
  EXPECT_NE(complaint(R"("tool":"emboss","radius_mm":3)").find("image"), std::string::npos);
  EXPECT_NE(complaint(R"("tool":"emboss","radius_mm":3,"file":"no.png")").find("no.png"), std::string::npos);
  EXPECT_NE(complaint(R"("tool":"stamp","radius_mm":3,"file":"no.stl")").find("no.stl"), std::string::npos);
  EXPECT_NE(complaint(R"("tool":"layer","radius_mm":3,"height_mm":-1)").find("height_mm"), std::string::npos);
  EXPECT_NE(complaint(R"("tool":"carve","radius_mm":3,"tip":"spoon")").find("spoon"), std::string::npos);
  EXPECT_NE(complaint(R"("tool":"paint","radius_mm":3,"colour":"red")").find("colour"), std::string::npos);
  EXPECT_NE(complaint(R"("tool":"smooth","radius_mm":3,"inverted":true)").find("inverted"), std::string::npos);
  EXPECT_NE(complaint(R"("tool":"tug","radius_mm":3,"radial":{"turns":99,"axis":[0,0,0,0,0,1]})").find("turns"),
            std::string::npos);
}

}  // namespace
}  // namespace argil::tests
