// Editors of Windows put a byte order mark before a text.
#include <gtest/gtest.h>

#include "io/models/model_file.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

const std::string kMark = "\xef\xbb\xbf";

struct Sample {
  const char* file;
  std::string text;
};

std::string binaryPly() {
  std::string bytes =
      "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
      "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
  for (const float x : {0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) samples::append(bytes, x);
  samples::append(bytes, uint8_t(3));
  for (const int32_t i : {0, 1, 2}) samples::append(bytes, i);
  return bytes;
}

std::vector<Sample> samplesOfTexts() {
  return {
      {"lower.stl",
       "solid x\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 0\nendloop\nendfacet\n"
       "endsolid x\n"},
      {"upper.stl",
       "SOLID X\r\nFACET NORMAL 0 0 1\r\nOUTER LOOP\r\nVERTEX 0 0 0\r\nVERTEX 1 0 0\r\nVERTEX 0 1 0\r\nENDLOOP\r\n"
       "ENDFACET\r\nENDSOLID X\r\n"},
      {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"},
      {"counts.off", "3 1 0\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n3 0 1 2\r\n"},
      {"a.ply",
       "ply\r\nformat ascii 1.0\r\nelement vertex 3\r\nproperty float x\r\nproperty float y\r\nproperty float z\r\n"
       "element face 1\r\nproperty list uchar int vertex_indices\r\nend_header\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n3 0 1 "
       "2\r\n"},
      {"binary.ply", binaryPly()},
      {"a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
      {"comment.obj", "# made by hand\nv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n"},
      {"a.gltf",
       R"({"asset":{"version":"2.0"},"scenes":[{"nodes":[0]}],"nodes":[{"mesh":0}],"meshes":[{"primitives":[{"attributes":)"
       R"({"POSITION":0}}]}],"accessors":[{"bufferView":0,"componentType":5126,"count":3,"type":"VEC3"}],"bufferViews":)"
       R"([{"buffer":0,"byteLength":36}],"buffers":[{"byteLength":36,"uri":"data:application/octet-stream;base64,)"
       R"(AAAAAAAAAAAAAAAAAACAPwAAAAAAAAAAAAAAAAAAgD8AAAAA"}]})"},
  };
}

TEST(ByteOrderMark, BeforeATextChangesNothing) {
  const samples::Folder folder;
  for (const auto& [name, text] : samplesOfTexts()) {
    SCOPED_TRACE(name);
    // The content says what it is, as a file's name does.
    for (const std::string& file : {std::string(name), std::string("no-ending")}) {
      if (file == "no-ending" && std::string(name) == "counts.off") continue;
      samples::spill(folder / file, text);
      const ModelFile plain = readModel(folder / file);
      samples::spill(folder / file, kMark + text);
      const ModelFile marked = readModel(folder / file);
      ASSERT_EQ(marked.objects.size(), 1u);
      EXPECT_EQ(marked.format, plain.format);
      EXPECT_EQ(marked.objects[0].mesh.positions, plain.objects[0].mesh.positions);
      EXPECT_EQ(marked.objects[0].mesh.triangles, plain.objects[0].mesh.triangles);
      EXPECT_EQ(marked.notes, plain.notes);
    }
  }
}

TEST(ByteOrderMark, BeforeMaterialsChangesNothing) {
  const samples::Folder folder;
  samples::spill(folder / "a.mtl", kMark + "newmtl red\r\nKd 1 0 0\r\n");
  samples::spill(folder / "a.obj",
                 kMark + "mtllib a.mtl\r\nv 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nusemtl red\r\nf 1 2 3\r\n");
  const ModelFile model = readModel(folder / "a.obj");
  EXPECT_EQ(model.objects.at(0).colour, (Colour{255, 0, 0, 255}));
  EXPECT_TRUE(model.notes.empty());
}

TEST(ByteOrderMark, InAHeaderOfBytesIsData) {
  std::string bytes = kMark + "exported";
  bytes.resize(80, ' ');
  samples::append(bytes, uint32_t(1));
  for (const float x : {0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f, 0.f, 0.f, 1.f, 0.f}) samples::append(bytes, x);
  samples::append(bytes, uint16_t(0));
  const ModelFile model = parseModel(samples::bytesOf(bytes), "a.stl");
  EXPECT_EQ(model.format, "STL (binary)");
  EXPECT_EQ(model.objects.at(0).mesh.positions.at(1), Vec3d(1, 0, 0));
}

TEST(ByteOrderMark, AloneIsNoModel) {
  for (const char* name : {"a.stl", "a.obj", "a.off", "a.ply"})
    samples::errorOf([&] { (void)parseModel(samples::bytesOf(kMark), name); });
  EXPECT_NE(
      samples::errorOf([&] { (void)parseModel(samples::bytesOf(kMark + "v 0 0 0\nv 1 0\n"), "a.obj"); }).find("line 2"),
      std::string::npos);
}

}  // namespace
}  // namespace argil::io
