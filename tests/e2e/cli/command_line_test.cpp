// The command as a person runs it: exit codes, one line of complaint, files that are whole or not there.

#include <gmock/gmock.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <vector>

#include "clay/mesh_topology.h"
#include "engine/script.h"
#include "io/mesh_file.h"
#include "io/mesh_writer.h"

namespace argil {
namespace {

namespace fs = std::filesystem;
using ::testing::HasSubstr;
using ::testing::StartsWith;

struct Ran {
  int code = -1;  // 128 + n: ended by signal n
  std::string out, err;
};

class CommandLine : public ::testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("argil-e2e-" + std::to_string(::getpid()));
    fs::create_directories(folder_);
  }
  void TearDown() override { fs::remove_all(folder_); }

  [[nodiscard]] std::string path(const std::string& name) const { return (folder_ / name).string(); }
  [[nodiscard]] static std::string read(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    std::stringstream text;
    text << file.rdbuf();
    return text.str();
  }
  void write(const std::string& name, const std::string& text) const { std::ofstream(path(name), std::ios::binary) << text; }

  [[nodiscard]] Ran run(const std::string& arguments) const {
    Ran ran;
    const std::string command = std::string("'") + ARGIL_COMMAND + "' " + arguments + " >'" + path("out") + "' 2>'" + path("err") + "'";
    const int status = std::system(command.c_str());
    ran.code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    ran.out = read(path("out"));
    ran.err = read(path("err"));
    return ran;
  }

  // What is in the folder besides what run() leaves.
  [[nodiscard]] std::vector<std::string> files() const {
    std::vector<std::string> names;
    for (const auto& entry : fs::directory_iterator(folder_)) {
      const std::string name = entry.path().filename().string();
      if (name != "out" && name != "err") names.push_back(name);
    }
    std::sort(names.begin(), names.end());
    return names;
  }

  void expectRefused(const Ran& ran, const std::string& names) const {
    EXPECT_EQ(ran.code, 2) << ran.err;
    EXPECT_THAT(ran.err, StartsWith("argil: "));
    EXPECT_THAT(ran.err, HasSubstr(names));
    EXPECT_EQ(std::count(ran.err.begin(), ran.err.end(), '\n'), 1) << ran.err;
  }

  fs::path folder_;
};

const char* const kScript = R"({"argil": 1, "units": "mm",
  "setup": [{"voxel_mm": 0.5}, {"block": {"size_mm": [30, 30, 15], "round_mm": 2}}], "strokes": [
  {"tool": "carve", "radius_mm": 3, "drive": "hand", "path": [[0,-8,0,14],[0.3,-8,0,8],[0.7,8,0,8],[1.0,8,0,14]]},
  {"tool": "add", "radius_mm": 2, "path": [[0,0,10,7],[1,5,10,7]]}]})";

TEST_F(CommandLine, SculptWritesWhatIsClosedAndRepeatable) {
  write("s.json", kScript);
  const Ran ran = run("sculpt " + path("s.json") + " -o " + path("a.stl") + " -o " + path("a.ply") + " --report " + path("r.json") +
                      " --record " + path("again.json"));
  ASSERT_EQ(ran.code, 0) << ran.err;
  EXPECT_THAT(ran.out, HasSubstr("closed"));
  for (const char* name : {"a.stl", "a.ply"}) {
    const clay::TopologyReport topology = clay::checkTopology(io::readMesh(path(name)).mesh);
    EXPECT_TRUE(topology.closed()) << name;
    EXPECT_EQ(topology.bodies, 1u) << name;
    EXPECT_NEAR(topology.volume, 30 * 30 * 15, 600) << name;
  }
  EXPECT_THAT(read(path("r.json")), HasSubstr("\"peak_force_n\""));
  EXPECT_EQ(engine::readScript(path("again.json")).strokes.size(), 2u);

  ASSERT_EQ(run("sculpt " + path("s.json") + " -o " + path("b.stl")).code, 0);
  EXPECT_EQ(read(path("a.stl")), read(path("b.stl")));
}

TEST_F(CommandLine, BadScriptsAndMeshesAreRefusedInOneLine) {
  write("s.json", kScript);
  write("bad.json", "{\"argil\": 1,");
  write("empty.stl", "");
  write("words.obj", "this is no mesh\n");
  const auto before = files();
  const std::string out = " -o " + path("x.stl");
  expectRefused(run("sculpt " + path("missing.json") + out), "missing.json");
  expectRefused(run("sculpt " + path("bad.json") + out), "bad.json: line 1");
  expectRefused(run("sculpt " + folder_.string() + out), folder_.filename().string());
  expectRefused(run("sculpt " + path("s.json") + " -i " + path("empty.stl") + out), "empty.stl");
  expectRefused(run("convert " + path("words.obj") + " " + path("x.stl")), "words.obj");
  expectRefused(run("convert " + path("missing.stl") + " " + path("x.stl")), "missing.stl");
  expectRefused(run("inspect " + path("empty.stl")), "empty.stl");
  expectRefused(run("sculpt --nonsense"), "");
  EXPECT_EQ(files(), before);
}

TEST_F(CommandLine, EveryTruncationOfABinaryMeshIsRefused) {
  write("s.json", kScript);
  ASSERT_EQ(run("sculpt " + path("s.json") + " -o " + path("whole.stl") + " -o " + path("whole.ply")).code, 0);
  for (const char* kind : {".stl", ".ply"}) {
    const std::string whole = read(path(std::string("whole") + kind));
    for (size_t i = 0; i < 50; ++i) {
      write(std::string("cut") + kind, whole.substr(0, whole.size() * i / 50));
      expectRefused(run("convert " + path(std::string("cut") + kind) + " " + path("x.obj")), std::string("cut") + kind);
      ASSERT_FALSE(fs::exists(path("x.obj"))) << kind << " " << i;
      if (HasFailure()) return;
    }
  }
}

TEST_F(CommandLine, AnOldFileStandsWhenWritingFails) {
  write("s.json", kScript);
  write("keep.stl", "precious");
  write("words.obj", "this is no mesh\n");
  expectRefused(run("convert " + path("words.obj") + " " + path("keep.stl")), "words.obj");
  EXPECT_EQ(read(path("keep.stl")), "precious");
}

TEST_F(CommandLine, ConvertKeepsAClosedMeshAndInspectSaysSo) {
  write("s.json", kScript);
  ASSERT_EQ(run("sculpt " + path("s.json") + " -o " + path("a.stl")).code, 0);
  ASSERT_EQ(run("convert " + path("a.stl") + " " + path("b.obj")).code, 0);
  const auto a = clay::checkTopology(io::readMesh(path("a.stl")).mesh), b = clay::checkTopology(io::readMesh(path("b.obj")).mesh);
  EXPECT_EQ(a.triangles, b.triangles);
  EXPECT_NEAR(a.volume, b.volume, 1e-3 * a.volume);
  const Ran told = run("inspect " + path("b.obj") + " --json");
  EXPECT_EQ(told.code, 0) << told.err;
  EXPECT_THAT(told.out, HasSubstr("\"closed\": true"));
}

TEST_F(CommandLine, DefectiveFilesOfTheCollectionAreRefused) {
  const char* data = std::getenv("ARGIL_DATA");
  if (!data) GTEST_SKIP() << "ARGIL_DATA is not set";
  for (const std::string name : {"malformed.obj", "notenoughindices.obj", "empty.stl", "invalid.off"}) {
    const std::string file = std::string(data) + "/mesh/" + name;
    if (!fs::exists(file)) GTEST_SKIP() << file << " is not there";
    expectRefused(run("convert '" + file + "' " + path("x.stl") + " --voxel 1"), name);
    EXPECT_FALSE(fs::exists(path("x.stl"))) << name;
  }
}

}  // namespace
}  // namespace argil
