// Quads with pictures on them, as OBJ and glTF.

#include "io/textured/textured_mesh.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <random>
#include <regex>

#include "gltf_peer.h"
#include "io/models/model_file.h"
#include "io/models/picture.h"
#include "io/textured/png.h"
#include "tests/support/gltf_rules.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

std::string slurp(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  return {std::istreambuf_iterator<char>(in), {}};
}
std::string text(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

TEST(Png, EveryNumberComesBack) {
  std::mt19937 random(5);
  for (const auto& [width, height] : {std::pair{1, 1}, {7, 3}, {64, 65}}) {
    const size_t count = size_t(width) * size_t(height);
    // Noise, and a slope that filters do well on.
    for (const bool smooth : {false, true}) {
      std::vector<uint8_t> rgb(3 * count);
      std::vector<uint16_t> grey(count);
      for (size_t i = 0; i < rgb.size(); ++i) rgb[i] = static_cast<uint8_t>(smooth ? i / 3 * 2 : random());
      for (size_t i = 0; i < grey.size(); ++i) grey[i] = static_cast<uint16_t>(smooth ? 37 * i : random());
      const std::vector<std::byte> colour = pngOf(width, height, std::span<const uint8_t>(rgb));
      const ColourImage read = unpackPicture(colour, 100);
      ASSERT_EQ(read.width, width);
      ASSERT_EQ(read.height, height);
      for (size_t i = 0; i < count; ++i) {
        for (size_t k = 0; k < 3; ++k) ASSERT_EQ(read.rgba[4 * i + k], rgb[3 * i + k]);
        ASSERT_EQ(read.rgba[4 * i + 3], 255);
      }
      const samples::Folder folder;
      samples::spill(folder / "a.png", text(pngOf(width, height, std::span<const uint16_t>(grey))));
      const GreyImage levels = readGreyImage(folder / "a.png", 100);
      for (size_t i = 0; i < count; ++i) ASSERT_NEAR(levels.grey[i] * 65535, grey[i], 0.01) << i;
    }
  }
}

TEST(Png, WhatIsSmoothIsSmall) {
  std::vector<uint16_t> slope(256 * 256);
  for (size_t i = 0; i < slope.size(); ++i) slope[i] = static_cast<uint16_t>(200 * (i % 256) + 3 * (i / 256));
  EXPECT_LT(pngOf(256, 256, std::span<const uint16_t>(slope)).size(), slope.size() / 4);
}

/// A box from (0, 0, 0) to (10, 20, 30) mm.
TexturedObject box(const std::string& name) {
  TexturedObject object;
  object.name = name;
  object.colour = {200, 100, 50, 255};
  for (int i = 0; i < 8; ++i)
    object.mesh.positions.push_back(Vec3d((i & 1) != 0 ? 10 : 0, (i & 2) != 0 ? 20 : 0, (i & 4) != 0 ? 30 : 0));
  object.mesh.quads = {{0, 2, 3, 1}, {4, 5, 7, 6}, {0, 1, 5, 4}, {2, 6, 7, 3}, {0, 4, 6, 2}, {1, 3, 7, 5}};
  object.map = clay::unwrapped(object.mesh, {}, clay::WorkPart(nullptr));
  object.frames = clay::framesOf(object.mesh, object.map);
  std::vector<uint8_t> colours(3 * 16), normals(3 * 16, 128);
  std::vector<uint16_t> heights(16);
  for (size_t i = 0; i < 16; ++i) colours[3 * i] = uint8_t(16 * i), heights[i] = uint16_t(4000 * i);
  object.colours = pngOf(4, 4, std::span<const uint8_t>(colours));
  object.normals = pngOf(4, 4, std::span<const uint8_t>(normals));
  object.heights = pngOf(4, 4, std::span<const uint16_t>(heights));
  object.heightMm = 1.5;
  return object;
}

std::vector<std::string> names(const std::filesystem::path& folder) {
  std::vector<std::string> out;
  for (const auto& each : std::filesystem::directory_iterator(folder)) out.push_back(each.path().filename().string());
  std::sort(out.begin(), out.end());
  return out;
}

class TexturedFile : public ::testing::Test {
 protected:
  static void SetUpTestSuite() { box_ = new TexturedObject(box("Box")); }
  static void TearDownTestSuite() { delete box_, box_ = nullptr; }
  static TexturedObject* box_;
  const samples::Folder folder_;
};
TexturedObject* TexturedFile::box_ = nullptr;

TEST_F(TexturedFile, ObjHasQuadsAndItsPicturesBesideIt) {
  const std::vector<TexturedObject> objects = {*box_, *box_};
  EXPECT_THAT(writeTextured(folder_ / "out.obj", objects),
              ElementsAre("out_colour.png", "out_normal.png", "out_displacement.png", "out_2_colour.png",
                          "out_2_normal.png", "out_2_displacement.png", "out.mtl", "out.obj"));
  std::vector<std::string> beside = texturedNames(folder_ / "out.obj", 2), there = names(folder_.path());
  beside.push_back("out.obj");
  std::sort(beside.begin(), beside.end());
  EXPECT_EQ(beside, there);
  EXPECT_EQ(slurp(folder_ / "out_2_normal.png"), text(box_->normals));
  const std::string material = slurp(folder_ / "out.mtl");
  EXPECT_THAT(material, HasSubstr("newmtl out\n"));
  EXPECT_THAT(material, HasSubstr("map_Kd out_colour.png\n"));
  EXPECT_THAT(material, HasSubstr("norm out_2_normal.png\n"));
  EXPECT_THAT(material, HasSubstr("disp -mm -1.5 3 out_displacement.png\n"));
  const std::string words = slurp(folder_ / "out.obj");
  const auto count = [&](const char* line) {
    const std::regex pattern(line, std::regex::multiline);
    return std::distance(std::sregex_iterator(words.begin(), words.end(), pattern), {});
  };
  EXPECT_EQ(count("^f( [0-9]+/[0-9]+/[0-9]+){4}$"), 12);
  EXPECT_EQ(count("^v "), 16);
  EXPECT_EQ(size_t(count("^vt ")), 2 * box_->map.places.size());
  EXPECT_EQ(count("^usemtl out_2$"), 1);
  const ModelFile read = readModel(folder_ / "out.obj");
  ASSERT_EQ(read.objects.size(), 2u);
  for (const ModelObject& object : read.objects) {
    EXPECT_EQ(object.name.substr(0, 3), "Box");
    EXPECT_EQ(object.mesh.triangles.size(), 12u);
    double volume = 0;
    for (const auto& t : object.mesh.triangles)
      volume += object.mesh.positions[t[0]].dot(object.mesh.positions[t[1]].cross(object.mesh.positions[t[2]])) / 6;
    EXPECT_NEAR(volume, 6000, 1e-9) << "closed, facing outwards";
  }
}

TEST_F(TexturedFile, GlbKeepsTheRulesAndHoldsItsPictures) {
  TexturedObject plain = *box_;
  plain.colours.clear();
  plain.normals.clear();
  plain.name = "Plain";
  const std::vector<TexturedObject> objects = {*box_, plain};
  EXPECT_THAT(writeTextured(folder_ / "out.glb", objects), ElementsAre("out.glb"));
  EXPECT_THAT(names(folder_.path()), ElementsAre("out.glb"));
  const std::string bytes = slurp(folder_ / "out.glb");
  EXPECT_EQ(samples::errorsAndWarnings(samples::gltfIssues(bytes)), "");
  EXPECT_NE(bytes.find(text(box_->colours)), std::string::npos);
  EXPECT_NE(bytes.find(text(box_->normals)), std::string::npos);
  const std::vector<PeerObject> peers = readByPeer(folder_ / "out.glb");
  ASSERT_EQ(peers.size(), 2u);
  for (const PeerObject& peer : peers) {
    EXPECT_EQ(peer.positionsMm.size(), box_->map.places.size());
    ASSERT_EQ(peer.triangles.size(), 12u);
    double volume = 0;
    for (const auto& t : peer.triangles)
      volume += peer.positionsMm[t[0]].dot(peer.positionsMm[t[1]].cross(peer.positionsMm[t[2]])) / 6;
    EXPECT_NEAR(volume, 6000, 1e-2);
    for (size_t i = 0; i < peer.normals.size(); ++i)
      EXPECT_GT(peer.normals[i].dot(peer.positionsMm[i] - Vec3d(5, 10, 15)), 0);
  }
  EXPECT_EQ(peers[1].name, "Plain");
  EXPECT_EQ(peers[1].baseColour, (std::array<uint8_t, 4>{200, 100, 50, 255}));
}

// The judge finds what a writer of pictures may do wrong.
TEST_F(TexturedFile, TheRulesOfPicturesAreLookedAt) {
  (void)writeTextured(folder_ / "out.glb", std::span(box_, 1));
  const std::string bytes = slurp(folder_ / "out.glb");
  const auto issues = [&](const std::string& from, const std::string& to) {
    EXPECT_EQ(from.size(), to.size());
    std::string changed = bytes;
    const size_t at = changed.find(from);
    EXPECT_NE(at, std::string::npos) << from;
    changed.replace(at, from.size(), to);
    return samples::errorsAndWarnings(samples::gltfIssues(changed));
  };
  EXPECT_THAT(issues("TEXCOORD_0", "TEXCOORD_1"), HasSubstr("MESH_PRIMITIVE_TOO_FEW_TEXCOORDS"));
  EXPECT_THAT(issues("TANGENT", "BITANGE"), HasSubstr("MESH_PRIMITIVE_INVALID_ATTRIBUTE"));
  EXPECT_THAT(issues("\x89PNG", "\x89PNX"), HasSubstr("IMAGE_UNRECOGNIZED_FORMAT"));
  EXPECT_THAT(issues("image/png", "image/gif"), HasSubstr("VALUE_NOT_IN_LIST"));
  EXPECT_THAT(issues("\"mimeType\"", "\"mimeTypo\""), HasSubstr("IMAGE_BUFFER_VIEW_WITHOUT_MIME_TYPE"));
  EXPECT_THAT(issues("\"source\":0", "\"source\":7"), HasSubstr("UNRESOLVED_REFERENCE"));
}

TEST_F(TexturedFile, AllFilesOrNone) {
  Job job;
  job.cancel();
  EXPECT_THROW((void)writeTextured(folder_ / "out.obj", std::span(box_, 1), &job), Cancelled);
  EXPECT_THAT(names(folder_.path()), IsEmpty());
  // The last file's name is taken by a folder.
  std::filesystem::create_directory(folder_ / "out.obj");
  EXPECT_THROW((void)writeTextured(folder_ / "out.obj", std::span(box_, 1)), Error);
  EXPECT_THAT(names(folder_.path()), ElementsAre("out.obj"));
  EXPECT_THROW((void)writeTextured(folder_ / "nowhere/out.glb", std::span(box_, 1)), Error);
}

}  // namespace
}  // namespace argil::io
