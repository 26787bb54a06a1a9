// Outputs never take the place of an input, and of a file that is there only when they are told to.

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <algorithm>
#include <cstdlib>
#include <functional>
#include <string>
#include <thread>
#include <vector>

#include "tests/e2e/support/command.h"

namespace argil::tests {
namespace {

using testing::HasSubstr;
using Words = std::vector<std::string>;

const char* const kBall = R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 1}, {"sphere": {"radius_mm": 8}}],
"strokes": [{"tool": "carve", "radius_mm": 2, "path": [[0, 8, 0, 0]]}]})";
const char* const kTetrahedron = "v 0 0 0\nv 20 0 0\nv 0 20 0\nv 0 0 20\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n";
const char* const kPath = "t_s,x_mm,y_mm,z_mm\n0,5,5,5\n0.1,5,5,6\n";

void put(const fs::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary) << text;
}

class OutputFiles : public testing::Test {
 protected:
  void SetUp() override {
    unsetenv("XDG_STATE_HOME");
    put(folder / "ball.json", kBall);
    put(folder / "a.obj", kTetrahedron);
    put(folder / "path.csv", kPath);
    ASSERT_EQ(argil({"sculpt", at("ball.json"), "-o", at("ball.argil")}).code, 0);
  }
  [[nodiscard]] std::string at(const std::string& name) const { return (folder / name).string(); }
  // One line that holds `words`, exit 2, and every file as it was.
  void refused(const Words& call, const std::string& words) const {
    std::vector<std::pair<fs::path, std::string>> before;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path()))
      if (entry.is_regular_file()) before.emplace_back(entry.path(), slurp(entry.path()));
    const Outcome outcome = argil(call);
    std::string said;
    for (const std::string& word : call) said += word + " ";
    EXPECT_EQ(outcome.code, 2) << said << outcome.err;
    EXPECT_THAT(outcome.err, HasSubstr(words)) << said;
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    size_t files = 0;
    for (const auto& entry : fs::recursive_directory_iterator(folder.path())) files += entry.is_regular_file();
    EXPECT_EQ(files, before.size()) << said;
    for (const auto& [file, text] : before) EXPECT_EQ(slurp(file), text) << file << " after " << said;
  }

  Scratch folder;
};

// A call without what it writes, the option that names it, and its ending.
struct Call {
  Words words, option;
  std::string ending;
};

// Lists a call for each verb that writes and each way of writing.
std::vector<Call> calls(const std::function<std::string(const std::string&)>& at) {
  std::vector<Call> all{
      {{"convert", at("a.obj"), "--voxel", "1"}, {}, ".ply"},
      {{"convert", at("ball.argil"), "--quads", "100"}, {}, ".obj"},
      {{"convert", at("ball.argil"), "--for", "slicer"}, {}, ".3mf"},
      {{"sculpt", at("ball.json")}, {"--png"}, ".png"},
      {{"sculpt", at("ball.json")}, {"--before-png"}, ".png"},
      {{"sculpt", at("ball.json")}, {"--report"}, ".json"},
      {{"sculpt", at("ball.json")}, {"--record"}, ".json"},
      {{"sculpt", at("ball.json"), "-i", at("a.obj"), "--voxel", "1"}, {"-o"}, ".stl"},
      {{"render", at("ball.argil")}, {"-o"}, ".png"},
      {{"render", at("a.obj")}, {"-o"}, ".png"},
      {{"feel", at("a.obj"), "--voxel", "1", "--path", at("path.csv")}, {"-o"}, ".csv"},
      {{"bench", "extremes"}, {"--json"}, ".json"},
      {{"bench", "stability"}, {"--figure"}, ".svg"},
  };
  for (const char* ending : {".stl", ".obj", ".ply", ".3mf", ".glb", ".gltf", ".drc"})
    all.push_back({{"convert", at("a.obj")}, {}, ending});
  for (const char* ending : {".argil", ".vdb", ".stl"}) {
    all.push_back({{"convert", at("ball.argil")}, {}, ending});
    all.push_back({{"sculpt", at("ball.json")}, {"-o"}, ending});
  }
  for (const char* ending : {".step", ".stp", ".iges", ".igs"})
    all.push_back({{"convert", at("ball.argil"), "--faces", "24"}, {}, ending});
  return all;
}
// Those take minutes when they are not refused.
bool isLong(const Call& call) {
  return call.words[0] == "bench" || call.ending.starts_with(".st") || call.ending.starts_with(".ig");
}
Words whole(Words call, const Words& option, const std::string& output) {
  call.insert(call.end(), option.begin(), option.end());
  call.push_back(output);
  return call;
}

TEST_F(OutputFiles, AFileThatIsThereStaysUnlessOverwriteIsGiven) {
  for (const Call& call : calls([&](const std::string& name) { return at(name); })) {
    const std::string output = at("out" + call.ending);
    put(output, "mine");
    Words words = whole(call.words, call.option, output);
    refused(words, "out" + call.ending + ": exists already; give --overwrite to replace it, or another name");
    fs::create_symlink(output, folder / ("link" + call.ending));
    refused(whole(call.words, call.option, at("link" + call.ending)), "exists already");
    words.emplace_back("--overwrite");
    if (!isLong(call) || call.ending == ".stl") {
      const Outcome outcome = argil(words);
      EXPECT_EQ(outcome.code, 0) << call.words[0] << " " << output << ": " << outcome.err;
      EXPECT_NE(slurp(output), "mine") << output;
    }
    for (const char* name : {"link", "out"}) fs::remove(folder / (name + call.ending));
    fs::remove(folder / "out.mtl");
  }
}

// Programs write their own state again and again without a word: what lies in the folder that XDG_STATE_HOME names.
TEST_F(OutputFiles, FilesInTheFolderOfProgramsStateAreReplaced) {
  fs::create_directories(folder / "state/deep");
  fs::create_directory(folder / "state2");
  fs::create_symlink(folder / "state", folder / "door");
  put(folder / "state/a.obj", kTetrahedron);
  for (const std::string& state : {at("state"), at("state/"), at("door")}) {
    setenv("XDG_STATE_HOME", state.c_str(), 1);
    for (const char* name : {"state/out.stl", "state/deep/out.stl", "state/deep/../out.stl", "door/out.stl"}) {
      put(folder / name, "mine");
      const Outcome outcome = argil({"convert", at("a.obj"), at(name)});
      EXPECT_EQ(outcome.code, 0) << outcome.err;
      EXPECT_NE(slurp(folder / name), "mine") << name;
    }
    for (const char* name : {"out.stl", "state2/out.stl", "state/../out.stl"}) {
      put(folder / name, "mine");
      refused({"convert", at("a.obj"), at(name)}, "exists already");
    }
    refused({"convert", at("state/a.obj"), at("door/a.obj")}, "is the input");
  }
  put(folder / "state/out.stl", "mine");
  for (const char* none : {"", "state"}) {  // A folder by a relative name counts for nothing.
    setenv("XDG_STATE_HOME", none, 1);
    refused({"convert", at("a.obj"), at("state/out.stl")}, "exists already");
  }
  unsetenv("XDG_STATE_HOME");
  refused({"convert", at("a.obj"), at("state/out.stl")}, "exists already");
}

TEST_F(OutputFiles, DevicesAndPipesAreAlwaysWritten) {
  const Words feel{"feel", at("a.obj"), "--voxel", "1", "--path", at("path.csv"), "-o"};
  for (const char* name : {"/dev/null", "/dev/stderr", "/dev/stdout", "/dev/fd/1"}) {
    const Outcome outcome = argil(whole(feel, {}, name));
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    const std::string& said = std::string(name) == "/dev/stderr" ? outcome.err : outcome.out;
    EXPECT_EQ(said.find("t_s,") != std::string::npos, std::string(name) != "/dev/null") << name << said;
  }
  EXPECT_TRUE(fs::is_character_file("/dev/null"));
  ASSERT_EQ(::mkfifo(at("pipe.csv").c_str(), 0600), 0);
  fs::create_symlink(folder / "pipe.csv", folder / "door.csv");
  for (const char* name : {"pipe.csv", "door.csv"}) {
    std::string read;
    std::thread reader([&] { read = slurp(folder / name); });
    EXPECT_EQ(argil(whole(feel, {}, at(name))).code, 0);
    reader.join();
    EXPECT_THAT(read, HasSubstr("t_s,")) << name;
  }
  EXPECT_TRUE(fs::is_fifo(folder / "pipe.csv"));
  EXPECT_EQ(argil(whole(feel, {}, folder.path().string())).code, 2);
}

TEST_F(OutputFiles, RecordingsAndReportsOfTheStudioCountToo) {
  put(folder / "mine.json", "mine");
  refused({"studio", "--record", at("mine.json")}, "mine.json: exists already");
  refused({"studio", "--report", at("mine.json")}, "mine.json: exists already");
  refused({"studio", at("ball.argil"), "--record", at("ball.argil"), "--overwrite"}, "is the input itself");
}

// By its name, by another spelling of it, through links of both kinds, and with --overwrite as well.
TEST_F(OutputFiles, AnInputIsNeverReplaced) {
  fs::create_directory(folder / "sub");
  const std::vector<std::pair<Words, std::string>> inputs{
      {{"convert", at("a.obj")}, "a.obj"},
      {{"convert", at("ball.argil")}, "ball.argil"},
      {{"sculpt", at("ball.json"), "--record"}, "ball.json"},
      {{"sculpt", at("ball.json"), "--report"}, "ball.json"},
      {{"sculpt", at("ball.json"), "-i", at("a.obj"), "-o"}, "a.obj"},
      {{"sculpt", at("ball.json"), "-i", at("ball.argil"), "-o"}, "ball.argil"},
      {{"feel", at("a.obj"), "--voxel", "1", "--path", at("path.csv"), "-o"}, "path.csv"},
      {{"render", at("a.obj"), "-o"}, "a.obj"},
  };
  for (const auto& [call, input] : inputs) {
    const std::string ending = fs::path(input).extension();
    fs::create_symlink(folder / input, folder / ("link" + ending));
    fs::create_hard_link(folder / input, folder / ("twin" + ending));
    fs::create_symlink(folder.path(), folder / "sub/up");
    for (const std::string& name : {at(input), at("./" + input), at("sub/../" + input), at("sub/up/" + input),
                                    at("link" + ending), at("twin" + ending)})
      for (const bool overwrite : {false, true}) {
        Words words = call;
        words.push_back(name);
        if (overwrite) words.emplace_back("--overwrite");
        refused(words, "is the input");
      }
    for (const std::string& link : {at("link" + ending), at("twin" + ending), at("sub/up")}) fs::remove(link);
  }
}

TEST_F(OutputFiles, FilesThatAScriptReadsAreInputs) {
  put(folder / "import.json", R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 1}, {"import": "a.obj"}],
"strokes": []})");
  refused({"sculpt", at("import.json"), "-o", at("a.obj"), "--overwrite"}, "is the input");
  put(folder / "grey.pgm", "P5\n2 2\n255\nabcd");
  put(folder / "emboss.json", R"({"argil": 1, "units": "mm", "setup": [{"voxel_mm": 1}, {"sphere": {"radius_mm": 8}}],
"strokes": [{"tool": "emboss", "radius_mm": 4, "height_mm": 1, "file": "grey.pgm", "path": [[0, 0, 0, 8]]}]})");
  refused({"sculpt", at("emboss.json"), "--png", at("grey.pgm"), "--overwrite"}, "is the input");
  refused({"feel", at("a.obj"), "--voxel", "1", "--path", at("path.csv"), "--texture",
           "image:" + at("grey.pgm") + ":0.1:0.1", "-o", at("grey.pgm"), "--overwrite"},
          "is the input");
}

TEST_F(OutputFiles, TwoOutputsOfOneNameAreRefused) {
  refused({"sculpt", at("ball.json"), "-o", at("x.stl"), "-o", at("./x.stl")}, "is named for two outputs");
  refused({"sculpt", at("ball.json"), "--png", at("x.png"), "--before-png", at("x.png")}, "is named for two outputs");
}

TEST_F(OutputFiles, FramesAndWhatComesBesideAModelCountToo) {
  put(folder / "turn-2.png", "mine");
  refused({"render", at("ball.argil"), "-o", at("turn-%d.png"), "--frames", "4"}, "turn-2.png: exists already");
  EXPECT_EQ(argil({"render", at("ball.argil"), "-o", at("turn-%d.png"), "--frames", "2"}).code, 0);
  fs::create_directory(folder / "page");
  for (const char* name : {"tradeoff.csv", "tradeoff.svg", "tradeoff.md"}) {
    put(folder / "page" / name, "mine");
    refused({"bench", "tradeoff", "--folder", at("page")}, "exists already");
    fs::remove(folder / "page" / name);
  }
  put(folder / "quads_normal.png", "mine");
  const Words quads{"convert", at("ball.argil"), at("quads.obj"), "--quads", "200"};
  Words pictures = quads;
  pictures.insert(pictures.end(), {"--textures", "16"});
  refused(pictures, "quads_normal.png: exists already");
  fs::rename(folder / "quads_normal.png", folder / "quads_40_colour.png");
  refused(pictures, "quads_40_colour.png: exists already");
  put(folder / "quads.mtl", "mine");
  refused(quads, "quads.mtl: exists already");
  fs::remove(folder / "quads.mtl");
  EXPECT_EQ(argil(quads).code, 0) << "no pictures are asked for";
  EXPECT_EQ(slurp(folder / "quads_40_colour.png"), "mine");
}

// What is refused is told before the model is read: here it could not be.
TEST_F(OutputFiles, AreLookedAtBeforeTheWork) {
  put(folder / "broken.obj", "v 0 0\nf 1 2 3\n");
  put(folder / "out.stl", "mine");
  refused({"convert", at("broken.obj"), at("out.stl")}, "out.stl: exists already");
  put(folder / "out.png", "mine");
  refused({"render", at("broken.obj"), "-o", at("out.png")}, "out.png: exists already");
}

}  // namespace
}  // namespace argil::tests
