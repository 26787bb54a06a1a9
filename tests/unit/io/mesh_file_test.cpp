#include "io/models/mesh_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/weld.h"
#include "io/bytes/input.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using samples::errorOf;

TEST(MeshFile, WhatIsNoReadableFileIsRefusedInOneSentence) {
  const samples::Folder folder;
  EXPECT_EQ(errorOf([&] { (void)readMesh(folder.path()); }),
            folder.path().string() + ": is a folder; name a file in it");
  const auto contains = [](const std::filesystem::path& path, const char* part) {
    const std::string error = errorOf([&] { (void)readMesh(path); });
    EXPECT_EQ(error.find(path.string()), 0u) << error;
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  contains(folder / "missing.stl", "there is no such file");
  contains(folder / "missing" / "a.stl", "there is no such file");
  samples::spill(folder / "empty.stl", "");
  contains(folder / "empty.stl", "is empty (0 bytes)");
  contains("/dev/null", "is not a regular file");
  ASSERT_EQ(::mkfifo((folder / "pipe.stl").c_str(), 0600), 0);
  contains(folder / "pipe.stl", "is not a regular file");
  samples::spill(folder / "packed.ply.gz", "\x1f\x8b\x08 and so on");
  contains(folder / "packed.ply.gz", "gzip cannot unpack it");
  samples::spill(folder / "box.3mf", "PK\x03\x04 and so on");
  contains(folder / "box.3mf", "cut off");
  samples::spill(folder / "box.zip", "PK\x03\x04 and so on");
  contains(folder / "box.zip", "its archive has no end");
  samples::spill(folder / "letter.txt", "Dear reader,\n");
  contains(folder / "letter.txt", "is in no format that can be read");
}

TEST(MeshFile, NamesWithLineEndsStayOneLine) {
  const std::string error = errorOf([] { (void)readMesh("/no\nsuch/file\x1b.stl"); });
  EXPECT_EQ(error.find("/no?such/file?.stl: "), 0u) << error;
}

TEST(MeshFile, ContentDecidesBeforeTheEnding) {
  const samples::Folder folder;
  samples::spill(folder / "a.stl", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  samples::spill(folder / "b.obj", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n");
  samples::spill(folder / "C.OBJ", "\n# nothing before\nf 1 2 3\nv 0 0 0\nv 1 0 0\nv 0 1 0\n");
  EXPECT_EQ(readMesh(folder / "a.stl").format, "OBJ");
  EXPECT_EQ(readMesh(folder / "b.obj").format, "OFF");
  EXPECT_EQ(readMesh(folder / "C.OBJ").format, "OBJ");
}

TEST(MeshFile, NamesFromFilesAreCleanUtf8) {
  EXPECT_EQ(cleanName("  Gro\xc3\x9f \xe2\x82\xac \xf0\x9f\x8e\x88\t"), "Gro\xc3\x9f \xe2\x82\xac \xf0\x9f\x8e\x88");
  // Cut off, overlong, a surrogate, beyond Unicode, control characters.
  EXPECT_EQ(cleanName("a\xc3"), "a?");
  EXPECT_EQ(cleanName("\xc0\xaf.\xe0\x80\x80.\xed\xa0\x80.\xf4\x90\x80\x80"), "??.???.???.????");
  EXPECT_EQ(cleanName("a\nb\x1b\x7f"), "a?b??");
  EXPECT_EQ(cleanName(" \t "), "");
  const std::string longest = cleanName("a" + std::string(150, 'b') + std::string(100, '\xc3') + "\x9f");
  EXPECT_EQ(longest.size(), 200u);
  std::string cut;
  for (int i = 0; i < 150; ++i) cut += "\xc3\x9f";
  EXPECT_EQ(cleanName("a" + cut).size(), 199u) << "no half of a character";
}

TEST(MeshFile, ReadsThroughALink) {
  const samples::Folder folder;
  samples::spill(folder / "a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
  std::filesystem::create_symlink("a.obj", folder / "link");
  EXPECT_EQ(readMesh(folder / "link").mesh.triangles.size(), 1u);
}

TEST(MeshFile, AJobSeesProgressAndCancels) {
  std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
  for (int i = 0; i < 10000; ++i) text += "f 1 2 3\n";
  Job job;
  EXPECT_EQ(parseMesh(samples::bytesOf(text), "a.obj", &job).mesh.triangles.size(), 10000u);
  EXPECT_EQ(job.fraction(), 1);
  job.cancel();
  EXPECT_THROW((void)parseMesh(samples::bytesOf(text), "a.obj", &job), Cancelled);
}

struct Real {
  const char* name;
  const char* format;
  uint64_t triangles;
  uint64_t boundaryEdges;
  uint64_t nonManifoldEdges;
  uint64_t bodies;  ///< 0: not known from elsewhere.
};

/// From the list that came with the data: counted by another program, after welding equal coordinates.
constexpr Real kReal[] = {
    {"ADIS16480.STL", "STL (text)", 7436, 0, 0, 0},
    {"armadillo_29k.obj", "OBJ", 29170, 0, 0, 0},
    {"cycloidal.ply", "PLY (binary)", 43368, 0, 242, 100},
    {"dragon_vrip_res3.ply", "PLY (text)", 47794, 0, 2094, 0},
    {"elephant-with-holes.off", "OFF", 4463, 1353, 0, 0},
    {"fandisk.obj", "OBJ", 12946, 0, 0, 0},
    {"featuretype.STL", "STL (binary)", 3476, 576, 0, 0},
    {"gebco7510_55cl_utm.stl", "STL (binary)", 4998, 50, 0, 0},
    {"goblet_vase.stl", "STL (binary)", 10910, 0, 0, 0},
    {"koala_100k.obj", "OBJ", 99994, 0, 0, 0},
    {"many_small_holes.ply", "PLY (binary)", 3524, 556, 0, 0},
    {"nefertiti_lowres.obj", "OBJ", 70000, 0, 0, 0},
    {"non_manif_hole.ply", "PLY (binary)", 755, 119, 0, 0},
    {"opensubdiv_catmark_cube_level0.obj", "OBJ", 48, 0, 0, 0},
    {"opensubdiv_catmark_cube_level2.obj", "OBJ", 768, 0, 0, 0},
    {"penguin_quad_cage.obj", "OBJ", 398, 0, 0, 0},
    {"rocker-arm.obj", "OBJ", 20088, 0, 0, 0},
    {"self_intersectA.obj", "OBJ", 17160, 0, 0, 0},
    {"spot.obj", "OBJ", 1654, 0, 0, 0},
    {"spot_quad_cage.obj", "OBJ", 372, 0, 0, 0},
    {"stanford-bunny.obj", "OBJ", 69451, 223, 0, 0},
    {"suzanne.obj", "OBJ", 968, 42, 1, 0},
    {"teapot.obj", "OBJ", 6320, 160, 0, 3},
    {"thin_tray_1002_tray_bottom.STL", "STL (text)", 4520, 0, 0, 0},
    {"wallhole.obj", "OBJ", 66, 0, 0, 0},
};

TEST(MeshFile, RealMeshesHaveTheCountsThatOthersFound) {
  const std::filesystem::path data = samples::meshData();
  if (data.empty()) GTEST_SKIP() << "set ARGIL_DATA to the folder of test data";
  for (const Real& real : kReal) {
    SCOPED_TRACE(real.name);
    const MeshFile file = readMesh(data / real.name);
    EXPECT_EQ(file.format, real.format);
    EXPECT_EQ(file.mesh.triangles.size(), real.triangles);
    const clay::TopologyReport report = clay::checkTopology(clay::weldExact(file.mesh));
    EXPECT_EQ(report.boundaryEdges, real.boundaryEdges);
    EXPECT_EQ(report.nonManifoldEdges, real.nonManifoldEdges);
    if (real.bodies != 0) {
      EXPECT_EQ(report.bodies, real.bodies);
    }
  }
}

TEST(MeshFile, EveryRealMeshFileIsInATest) {
  const std::filesystem::path data = samples::meshData();
  if (data.empty()) GTEST_SKIP() << "set ARGIL_DATA to the folder of test data";
  constexpr std::string_view kElsewhere[] = {"empty.stl", "invalid.off", "malformed.obj", "notenoughindices.obj",
                                             "dragon_vrip_871k.ply.gz"};
  for (const auto& entry : std::filesystem::directory_iterator(data)) {
    const std::string name = entry.path().filename();
    const bool known = std::any_of(std::begin(kReal), std::end(kReal), [&](const Real& r) { return name == r.name; }) ||
                       std::find(std::begin(kElsewhere), std::end(kElsewhere), name) != std::end(kElsewhere);
    EXPECT_TRUE(known) << name;
  }
}

TEST(MeshFile, RealMalformedFilesAreRefused) {
  const std::filesystem::path data = samples::meshData();
  if (data.empty()) GTEST_SKIP() << "set ARGIL_DATA to the folder of test data";
  const auto contains = [&](const char* name, const char* part) {
    const std::string error = errorOf([&] { (void)readMesh(data / name); });
    EXPECT_NE(error.find(part), std::string::npos) << error;
  };
  contains("malformed.obj", "malformed.obj: line 28: a face names vertex 0");
  contains("notenoughindices.obj", "notenoughindices.obj: line 9: a face has 2 corners");
  contains("empty.stl", "empty.stl: holds no triangles");
  contains("invalid.off", "invalid.off: line 6: the file announces 4 faces");
}

TEST(MeshFile, ARealPackedScanIsRead) {
  const std::filesystem::path data = samples::meshData();
  if (data.empty()) GTEST_SKIP() << "set ARGIL_DATA to the folder of test data";
  const MeshFile dragon = readMesh(data / "dragon_vrip_871k.ply.gz");
  EXPECT_EQ(dragon.mesh.triangles.size(), 871414u);
  EXPECT_EQ(dragon.format, "PLY (text)");
}

}  // namespace
}  // namespace argil::io
