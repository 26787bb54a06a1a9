// The house plan holds in this tree, and the checks catch a tree in which it does not.

#include <gmock/gmock.h>
#include <unistd.h>

#include <fstream>

#include "house_rules.h"

namespace argil::house {
namespace {

namespace fs = std::filesystem;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::IsEmpty;

const fs::path kThisTree = ARGIL_SOURCE_DIR;

class PlantedTree : public ::testing::Test {
 protected:
  void SetUp() override { root_ = fs::temp_directory_path() / ("argil-house-" + std::to_string(::getpid())); }
  void TearDown() override { fs::remove_all(root_); }
  void plant(const std::string& path, const std::string& text) {
    fs::create_directories((root_ / path).parent_path());
    std::ofstream(root_ / path) << text;
  }
  fs::path root_;
};

TEST(House, ArrowsHold) {
  EXPECT_THAT(arrows(kThisTree), IsEmpty());
}

TEST(House, FoldersStandOnThoseBelow) {
  EXPECT_THAT(floors(kThisTree), IsEmpty());
}

TEST(House, NoFolderIsCrowded) {
  EXPECT_THAT(crowdedFolders(kThisTree), IsEmpty());
}

TEST(House, NoLineIsWide) {
  EXPECT_THAT(wideLines(kThisTree), IsEmpty());
}

TEST(House, SourcesAndTestsAreNamedInOneWay) {
  EXPECT_THAT(misnamedSources(kThisTree), IsEmpty());
}

TEST(House, WhatIsNamedIsThere) {
  EXPECT_THAT(danglingNames(kThisTree), IsEmpty());
}

TEST(House, HeavyHeadersStayInTheirRoom) {
  EXPECT_THAT(heavyHeaders(kThisTree), IsEmpty());
}

TEST(House, OthersParsersRunInTheReaderAlone) {
  EXPECT_THAT(foreignParsers(kThisTree), IsEmpty());
}

TEST(House, LongFilesHaveAReason) {
  EXPECT_THAT(longFiles(kThisTree), IsEmpty());
}

TEST(House, TheTreeIsReallyRead) {
  EXPECT_GT(sourceCount(kThisTree), 20u);
}

TEST_F(PlantedTree, EachForbiddenArrowIsCaught) {
  const std::vector<std::string> modules = {"clay",   "haptics", "io",          "render",
                                            "engine", "ui3d",    "plugins/sdk", "bench"};
  const std::vector<std::pair<std::string, std::string>> allowed = {
      {"haptics", "clay"},     {"io", "clay"},      {"render", "clay"},        {"engine", "haptics"},
      {"engine", "io"},        {"engine", "clay"},  {"ui3d", "engine"},        {"ui3d", "render"},
      {"ui3d", "haptics"},     {"ui3d", "io"},      {"engine", "plugins/sdk"}, {"ui3d", "clay"},
      {"ui3d", "plugins/sdk"}, {"bench", "engine"}, {"bench", "render"},       {"bench", "haptics"},
      {"bench", "io"},         {"bench", "clay"}};
  for (const std::string& to : modules) plant(to + "/a.h", "#pragma once\n");
  for (const std::string& from : modules) {
    for (const std::string& to : modules) {
      if (from == to) continue;
      plant(from + "/b.cpp", "// first\n  #  include \"" + to + "/a.h\"\n");
      const bool fine = std::find(allowed.begin(), allowed.end(), std::pair(from, to)) != allowed.end();
      const Breaches found = arrows(root_);
      EXPECT_EQ(found.empty(), fine) << from << " -> " << to;
      if (!fine) {
        EXPECT_THAT(found, ElementsAre(HasSubstr(from + "/b.cpp:2: includes " + to + "/a.h")));
      }
      fs::remove(root_ / from / "b.cpp");
    }
  }
}

TEST_F(PlantedTree, ByPathsAndMissingFilesAreCaught) {
  plant("clay/a.h", "#pragma once\n");
  plant("haptics/a.cpp", "#include \"../io/a.h\"\n");
  plant("io/a.h", "#include <haptics/gone.h>\n");
  plant("plugins/wave/wave.c", "#include \"clay/a.h\"\n");
  plant("tests/unit/clay/free.cpp", "#include \"clay/a.h\"\n");
  EXPECT_THAT(arrows(root_),
              ElementsAre(HasSubstr("leaves its folder"), HasSubstr("haptics/gone.h, which is not there"),
                          HasSubstr("no arrow leads from plugins/wave to clay")));
}

TEST_F(PlantedTree, AFolderThatSeesOneAboveIsCaught) {
  plant("clay/base/a.h", "#pragma once\n");
  plant("clay/store/b.h", "#include \"clay/base/a.h\"\n");
  plant("ui3d/studio/session.h", "#include \"ui3d/studio/view/camera.h\"\n");
  plant("ui3d/studio/view/camera.h", "#pragma once\n");
  EXPECT_THAT(floors(root_), IsEmpty());
  plant("clay/base/a.cpp", "#include \"clay/store/b.h\"\n");
  plant("clay/attic/c.h", "#pragma once\n");
  plant("ui3d/studio/view/camera.cpp", "#include \"ui3d/studio/session.h\"\n");
  EXPECT_THAT(floors(root_), ElementsAre(HasSubstr("clay/attic/c.h: its folder is none of the floors of clay"),
                                         HasSubstr("clay/store stands on clay/base"),
                                         HasSubstr("ui3d/studio stands on ui3d/studio/view")));
}

TEST_F(PlantedTree, ACrowdedFolderIsCaught) {
  for (int i = 0; i < 5; ++i) plant("clay/base/" + std::to_string(i) + ".h", "#pragma once\n");
  EXPECT_THAT(crowdedFolders(root_, 5), IsEmpty());
  plant("clay/base/5.cpp", "\n");
  EXPECT_THAT(crowdedFolders(root_, 5), ElementsAre(HasSubstr("clay/base: 6 files")));
}

TEST_F(PlantedTree, AWideLineIsCaught) {
  std::string greek;
  for (int i = 0; i < 120; ++i) greek += "\u03b1";
  plant("clay/base/a.h", greek + "\n");
  plant("clay/base/raw.cpp", "auto s = R\"(\n" + std::string(200, 'x') + "\n)\";\n");
  EXPECT_THAT(wideLines(root_), IsEmpty());
  plant("clay/base/b.h", "\n" + std::string(121, 'x') + "\n");
  plant("clay/base/raw.cpp", "auto s = R\"(\n" + std::string(200, 'x') + "\n)\";\n" + std::string(121, 'y') + "\n");
  EXPECT_THAT(wideLines(root_), ElementsAre(HasSubstr("clay/base/b.h:2: 121"), HasSubstr("clay/base/raw.cpp:4: 121")));
}

TEST_F(PlantedTree, ANameInAnotherWayIsCaught) {
  plant("clay/base/two_words.h", "");
  plant("tests/unit/clay/ball_test.cpp", "TEST(Ball, IsRound) {\n");
  EXPECT_THAT(misnamedSources(root_), IsEmpty());
  plant("clay/base/twoWords.h", "");
  plant("tests/unit/clay/ball_test.cpp", "TEST(Ball, isRound) {\nTEST_F(ball, IsRound) {\n");
  plant("tests/unit/clay/cone.cpp", "TEST_P(Cone, IsSharp) {\n");
  plant("tests/unit/clay/help_test.cpp", "int help() {\n");
  EXPECT_THAT(misnamedSources(root_),
              ElementsAre("clay/base/twoWords.h: is not in snake_case",
                          "tests/unit/clay/ball_test.cpp: Ball.isRound does not begin with a capital",
                          "tests/unit/clay/ball_test.cpp: ball.IsRound does not begin with a capital",
                          "tests/unit/clay/cone.cpp: holds tests and does not end in _test.cpp",
                          "tests/unit/clay/help_test.cpp: holds no test"));
}

TEST_F(PlantedTree, ANameOfNothingIsCaught) {
  plant("clay/base/a.h", "// See clay/base/a.h and `clay/base`.\n");
  plant("README.md", "`clay/base/a` and [it](clay/base/a.h), input/output\n");
  EXPECT_THAT(danglingNames(root_), IsEmpty());
  plant("README.md", "`clay/base/b` and\n[it](clay/base/b.h)\n");
  EXPECT_THAT(danglingNames(root_), ElementsAre("README.md:1: names clay/base/b", "README.md:2: names clay/base/b.h"));
}

TEST_F(PlantedTree, AHeavyHeaderSeenFromAnotherRoomIsCaught) {
  plant("clay/inner.h", "#include <openvdb/openvdb.h>\n");
  plant("clay/outer.h", "#include \"clay/inner.h\"\n");
  plant("clay/fine.cpp", "#include \"clay/outer.h\"\n");
  EXPECT_THAT(heavyHeaders(root_), IsEmpty());
  plant("io/file.cpp", "#include \"clay/outer.h\"\n");
  plant("render/device.h", "#include <volk.h>\n");
  plant("ui3d/main.cpp", "#include \"render/device.h\"\n");
  EXPECT_THAT(heavyHeaders(root_), ElementsAre(HasSubstr("io/file.cpp:1"), HasSubstr("ui3d/main.cpp:1")));
}

TEST_F(PlantedTree, AParserOutsideOfTheReaderIsCaught) {
  plant("io/reader/picture.cpp", "#include <stb_image.h>\n");
  plant("tests/unit/io/picture_test.cpp", "#include <stb_image.h>\n");
  EXPECT_THAT(foreignParsers(root_), IsEmpty());
  plant("render/png.cpp", "#include <stb_image.h>\n#include <stb_image_write.h>\n");
  EXPECT_THAT(foreignParsers(root_), ElementsAre(HasSubstr("render/png.cpp:1")));
}

TEST_F(PlantedTree, ALongFileWithoutAReasonIsCaught) {
  plant("io/long.cpp", std::string(601, '\n'));
  plant("io/short.cpp", std::string(600, '\n'));
  EXPECT_THAT(longFiles(root_), ElementsAre(HasSubstr("io/long.cpp: 601 lines")));
  plant("io/NOTES.md", "long.cpp is one table.\n");
  EXPECT_THAT(longFiles(root_), IsEmpty());
}

}  // namespace
}  // namespace argil::house
