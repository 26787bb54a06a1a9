// Whatever is wrong with the call or the input: exit 2, one line that a person can act on, nothing written.

#include "tests/e2e/support/command.h"
#include "tests/support/tier.h"

#include <algorithm>

namespace argil::tests {
namespace {

void expectRefused(const Outcome& o, const std::string& what) {
  EXPECT_EQ(o.code, 2) << what << ": " << o.err;
  EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << what << ": " << o.err;
  EXPECT_EQ(o.err.rfind("argil: ", 0), 0u) << what << ": " << o.err;
  EXPECT_GT(o.err.size(), 20u) << what;
  EXPECT_EQ(o.out, "") << what;
}

// Refused by every verb that reads a mesh, and nothing appears beside it.
void expectMeshRefused(const fs::path& mesh, const Scratch& scratch) {
  const fs::path output = scratch / "out.stl";
  const Outcome o = argil({"convert", mesh.string(), output.string()});
  expectRefused(o, mesh.string());
  EXPECT_NE(o.err.find(mesh.filename().string()), std::string::npos) << o.err;
  EXPECT_FALSE(fs::exists(output)) << mesh;
  for (const auto& entry : fs::directory_iterator(scratch.path()))
    EXPECT_EQ(entry.path().string().find(".tmp"), std::string::npos) << entry.path();
}

void writeFile(const fs::path& path, const std::string& text) {
  std::ofstream(path, std::ios::binary) << text;
}

TEST(BadInput, DamagedRealFilesAreRefused) {
  if (!realData()) GTEST_SKIP() << "ARGIL_DATA is not set";
  const Scratch scratch;
  for (const char* name : {"malformed.obj", "notenoughindices.obj", "empty.stl", "invalid.off"})
    expectMeshRefused(fs::path(realData()) / "mesh" / name, scratch);
}

TEST(BadInput, DirectoryMissingAndEmptyFilesAreRefused) {
  const Scratch scratch;
  fs::create_directory(scratch / "folder.stl");
  expectMeshRefused(scratch / "folder.stl", scratch);
  expectMeshRefused(scratch / "missing.obj", scratch);
  writeFile(scratch / "zero.stl", "");
  expectMeshRefused(scratch / "zero.stl", scratch);
  writeFile(scratch / "zero.ply", "");
  expectMeshRefused(scratch / "zero.ply", scratch);
}

TEST(BadInput, BinaryFilesCutAnywhereAreRefused) {
  const Scratch scratch;
  const fs::path script = scratch / "ball.json";
  writeFile(script, R"({"argil":1,"units":"mm","setup":[{"voxel_mm":0.5},{"sphere":{"radius_mm":5}}],"strokes":[]})");
  for (const std::string ending : {".stl", ".ply"}) {
    const fs::path whole = scratch / ("whole" + ending);
    const Outcome made = argil({"sculpt", script.string(), "-o", whole.string()});
    ASSERT_EQ(made.code, 0) << made.err;
    const std::string bytes = slurp(whole);
    ASSERT_GT(bytes.size(), 1000u);
    const auto places = byTier<size_t>(8, 50);
    for (size_t i = 0; i < places; ++i) {
      const fs::path cut = scratch / ("cut" + ending);
      writeFile(cut, bytes.substr(0, bytes.size() * i / places));
      expectMeshRefused(cut, scratch);
    }
  }
}

TEST(BadInput, CallsThatCannotBeMeantAreRefused) {
  const Scratch scratch;
  const std::string out = (scratch / "out.stl").string(), mesh = (scratch / "t.off").string();
  writeFile(mesh, "OFF\n4 4 0\n0 0 0\n10 0 0\n0 10 0\n0 0 10\n3 0 2 1\n3 0 1 3\n3 0 3 2\n3 1 2 3\n");
  const std::vector<std::vector<std::string>> calls = {
      {"studio", "--size", "a few"},
      {"sculpture"},
      {"convert"},
      {"convert", mesh},
      {"convert", mesh, (scratch / "out.xyz").string()},
      {"convert", mesh, out, "--units", "parsec"},
      {"convert", mesh, out, "--voxel", "0"},
      {"convert", mesh, out, "--voxel", "nan"},
      {"convert", mesh, out, "--voxel", "1e-9"},
      {"convert", mesh, out, "--nonsense"},
      {"render", mesh, "-o", (scratch / "a.png").string(), "--size", "5x5"},
      {"render", mesh, "-o", (scratch / "a.png").string(), "--view", "sideways"},
      {"render", mesh, "-o", (scratch / "a.png").string(), "--shading", "toon"},
      {"render", mesh, "-o", (scratch / "a.png").string(), "--matcap", "jade"},
      {"render", mesh, "-o", (scratch / "a.png").string(), "--stereo", "cross"},
      {"render", mesh, "-o", (scratch / "a.png").string(), "--eye-distance", "0.3"},
      {"render", mesh, "-o", (scratch / "a.png").string(), "--convergence", "nan"},
      {"render", mesh, "-o", (scratch / "a.png").string(), "--depth-fade", "2"},
      {"render", mesh, "-o", (scratch / "a.png").string(), "--section", "0,0,0,1,1"},
      {"render", mesh, "-o", (scratch / "a.png").string(), "--section", "0,0,0,0,0,0"},
      {"render", mesh, "-o", (scratch / "a.png").string(), "--samples", "5"},
      {"render", mesh, "-o", (scratch / "a.png").string(), "--frames", "0"},
      {"render", mesh, "-o", (scratch / "a.png").string(), "--frames", "4"},
      {"render", mesh, "-o", (scratch / "a-%d-%d.png").string(), "--frames", "4"},
      {"bench", "speed"},
      {"devices", "--test", "teapot"},
      {"devices", "--sheet", "teapot"},
      {"devices", "--sheet", "simulated:"},
      {"devices", "--sheet", "recorded:"},
      {"devices", "--test", "recorded:" + (scratch / "missing.csv").string()},
      {"sculpt", (scratch / "missing.json").string()},
      {"sculpt", (scratch / "missing.json").string(), "--quality", "best"},
      {"sculpt", (scratch / "missing.json").string(), "--quality", "fine,spacing=0"},
      {"sculpt", (scratch / "missing.json").string(), "--quality", "machines"},
      {"bench", "tradeoff", "--from", (scratch / "missing.csv").string()},
      {"inspect", (scratch / "missing.obj").string(), "--cost"},
  };
  for (const auto& call : calls) {
    std::string what;
    for (const std::string& a : call) what += a + ' ';
    const Outcome o = argil(call);
    EXPECT_EQ(o.code, 2) << what << o.err;
    EXPECT_EQ(std::count(o.err.begin(), o.err.end(), '\n'), 1) << what << o.err;
    EXPECT_FALSE(fs::exists(out)) << what;
    EXPECT_FALSE(fs::exists(scratch / "a.png")) << what;
  }
}

TEST(BadInput, ScriptsThatAreWrongNameThePlace) {
  const Scratch scratch;
  const fs::path script = scratch / "bad.json";
  const std::pair<const char*, const char*> scripts[] = {
      {"{", "bad.json"},
      {R"({"argil":2,"units":"mm","setup":[],"strokes":[]})", "argil"},
      {R"({"argil":1,"units":"mm","setup":[{"sphere":{"radius_mm":5}}],"strokes":[{"tool":"dig","radius_mm":1,"path":[[0,0,0,0]]}]})",
       "strokes[0]"},
      {R"({"argil":1,"units":"mm","setup":[{"sphere":{"radius_mm":5}}],"strokes":[{"tool":"carve","radius_mm":1,"path":[[0,0,0,0],[1,0,0]]}]})",
       "path[1]"},
      {R"({"argil":1,"units":"mm","setup":[{"sphere":{"radius_mm":5}}],"strokes":[{"tool":"carve","radius_mm":1e999,"path":[[0,0,0,0]]}]})",
       "bad.json"},
  };
  for (const auto& [text, place] : scripts) {
    writeFile(script, text);
    const Outcome o = argil({"sculpt", script.string(), "-o", (scratch / "out.stl").string()});
    expectRefused(o, text);
    EXPECT_NE(o.err.find(place), std::string::npos) << o.err;
    EXPECT_FALSE(fs::exists(scratch / "out.stl"));
  }
}

TEST(BadInput, AFailedWriteLeavesTheOldFile) {
  const Scratch scratch;
  const fs::path mesh = scratch / "t.off", out = scratch / "out.stl";
  writeFile(out, "precious");
  writeFile(mesh, "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 7\n");
  EXPECT_EQ(argil({"convert", mesh.string(), out.string()}).code, 2);
  EXPECT_EQ(slurp(out), "precious");
}

}  // namespace
}  // namespace argil::tests
