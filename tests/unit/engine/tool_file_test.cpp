// Files that tools work with are read beside the strokes.

#include <gtest/gtest.h>

#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "engine/tools/tool_table.h"
#include "workbench_rig.h"

namespace argil::engine {
namespace {

class ToolFileTest : public ::testing::Test {
 protected:
  ToolFileTest() {
    std::filesystem::create_directories(folder);
    bench.addBlock({40, 40, 20}, 2, {.voxelMm = 0.5});
    EXPECT_TRUE(until([&] { return bench.snapshot()->document->pieces.size() == 1 && bench.idle(); }));
  }
  ~ToolFileTest() override {
    std::error_code ignored;
    std::filesystem::remove_all(folder, ignored);
  }
  // A slope from black to white, `edge` pixels along each edge.
  std::string image(int edge) {
    const std::string path = (folder / ("slope" + std::to_string(edge) + ".pgm")).string();
    std::string row;
    for (int i = 0; i < edge; ++i) row.push_back(static_cast<char>(255 * i / std::max(1, edge - 1)));
    std::ofstream out(path, std::ios::binary);
    out << "P5\n" << edge << " " << edge << "\n255\n";
    for (int i = 0; i < edge; ++i) out << row;
    return path;
  }
  static Tool emboss(const std::string& file) {
    Tool tool = standardTool(*findTool("emboss"));
    tool.file = file;
    return tool;
  }
  bool reads() {
    for (const JobView& job : bench.jobs())
      if (job.name.starts_with("Reading")) return true;
    return false;
  }
  std::string problems() { return problemsOf(bench); }
  const std::vector<Vec3d> way{Vec3d(-8, 0, 10), Vec3d(8, 0, 10)};
  std::filesystem::path folder =
      std::filesystem::path(testing::TempDir()) / ("argil_tool_files_" + std::to_string(::getpid()));
  Workbench bench{withoutJournal()};
};

TEST_F(ToolFileTest, AStrokeOfAnotherToolIsDoneWhileALargeImageIsRead) {
  const std::string file = image(6000);
  const size_t steps = bench.snapshot()->done;
  bench.setTool(emboss(file));
  ASSERT_TRUE(until([&] { return reads(); })) << "the image is not read as a job";
  bench.setTool(standardTool(*findTool("carve")));
  bench.strokeAlong(way);
  ASSERT_TRUE(until([&] { return bench.snapshot()->done == steps + 1; }));
  EXPECT_TRUE(reads()) << "the stroke came after the image";
  ASSERT_TRUE(until([&] { return bench.idle(); }));
  EXPECT_EQ(problems(), "");
}

TEST_F(ToolFileTest, TheToolWorksOnceItsImageIsThereAndKeepsIt) {
  bench.setTool(emboss(image(64)));
  ASSERT_TRUE(until([&] { return bench.idle() && bench.snapshot()->tool.id == "emboss"; }));
  const uint64_t before = bench.snapshot()->document->pieces[0].version.hash();
  const size_t steps = bench.snapshot()->done;
  bench.strokeAlong(way);
  ASSERT_TRUE(until([&] { return bench.snapshot()->done == steps + 1; })) << problems();
  EXPECT_NE(bench.snapshot()->document->pieces[0].version.hash(), before);
  // Smooth for a moment, as with a key that is held: the image is not read again.
  std::filesystem::remove(folder / "slope64.pgm");
  bench.setTool(standardTool(*findTool("smooth")));
  bench.setTool(emboss((folder / "slope64.pgm").string()));
  bench.strokeAlong(way);
  ASSERT_TRUE(until([&] { return bench.snapshot()->done == steps + 2; })) << problems();
  EXPECT_EQ(problems(), "");
}

// A tool that waits for its image, or has none, touches the clay and leaves it; the one before and the one after cut.
TEST_F(ToolFileTest, AHandWithoutAnImageTouchesOnly) {
  Finger finger(bench);
  const auto press = [&] {
    for (int i = 0; i < 30; ++i) finger.feed(-10, 0, -8);
    for (int i = 0; i < 30; ++i) finger.feed(-10, 1, 1);
    for (int i = 0; i <= 40; ++i) finger.feed(-10 + 0.5 * i, 1, 1);
    for (int i = 0; i < 30; ++i) finger.feed(10, 0, -8);
    EXPECT_TRUE(until([&] { return bench.idle(); }));
    return bench.snapshot()->done;
  };
  const size_t steps = bench.snapshot()->done;
  bench.setTool(standardTool(*findTool("carve")));
  EXPECT_EQ(press(), steps + 1);
  bench.setTool(emboss(""));
  std::string said;
  ASSERT_TRUE(until([&] { return !(said += problems()).empty(); }));
  EXPECT_EQ(press(), steps + 1) << problems();
  EXPECT_EQ(problems(), "") << "said before, and not at every press";
  bench.setTool(standardTool(*findTool("carve")));
  EXPECT_EQ(press(), steps + 2);
}

TEST_F(ToolFileTest, ABadFileIsToldOnceAndNothingIsCut) {
  const std::string file = (folder / "notes.png").string();
  std::ofstream(file) << "no picture";
  bench.setTool(emboss(file));
  std::string said;
  ASSERT_TRUE(until([&] { return !(said += problems()).empty(); }));
  EXPECT_NE(said.find("notes.png"), std::string::npos) << said;
  ASSERT_TRUE(until([&] { return bench.idle(); }));
  EXPECT_EQ(problems(), "") << "told twice";
  const size_t steps = bench.snapshot()->done;
  bench.strokeAlong(way);
  ASSERT_TRUE(until([&] { return !(said = problems()).empty(); }));
  EXPECT_EQ(bench.snapshot()->done, steps);
  // A good one takes its place.
  bench.setTool(emboss(image(32)));
  ASSERT_TRUE(until([&] { return bench.idle() && bench.snapshot()->tool.file.ends_with("slope32.pgm"); }));
  bench.strokeAlong(way);
  ASSERT_TRUE(until([&] { return bench.snapshot()->done == steps + 1; })) << problems();
}

}  // namespace
}  // namespace argil::engine
