// Polygons of every format that has them, divided by one function.
#include <fmt/format.h>
#include <gtest/gtest.h>

#include <functional>

#include "io/models/mesh_file.h"
#include "io/models/model_writer.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

struct Face {
  const char* name;
  std::vector<Vec3d> corners;
  double area;
};

std::vector<Face> faces() {
  return {
      {"dart", {{0, 0, 0}, {4, 0, 0}, {1, 1, 0}, {0, 4, 0}}, 4},
      {"L", {{0, 0, 0}, {2, 0, 0}, {2, 1, 0}, {1, 1, 0}, {1, 2, 0}, {0, 2, 0}}, 3},
      {"L from its inner corner", {{1, 1, 0}, {1, 2, 0}, {0, 2, 0}, {0, 0, 0}, {2, 0, 0}, {2, 1, 0}}, 3},
      {"U on edge", {{0, 0, 0}, {0, 3, 0}, {0, 3, 3}, {0, 2, 3}, {0, 2, 1}, {0, 1, 1}, {0, 1, 3}, {0, 0, 3}}, 7},
      {"square with a hole behind a bridge",
       {{0, 0, 5}, {9, 0, 5}, {9, 9, 5}, {0, 9, 5}, {0, 0, 5}, {3, 3, 5}, {3, 6, 5}, {6, 6, 5}, {6, 3, 5}, {3, 3, 5}},
       72},
      {"arrow, turned over", {{0, 4, 0}, {1, 1, 0}, {4, 0, 0}, {0, 0, 0}}, 4},
  };
}

std::string places(const Face& face, const char* before) {
  std::string text;
  for (const Vec3d& p : face.corners) text += fmt::format("{}{} {} {}\n", before, p.x(), p.y(), p.z());
  return text;
}
std::string corners(const Face& face, size_t first) {
  std::string text;
  for (size_t i = 0; i < face.corners.size(); ++i) text += fmt::format(" {}", i + first);
  return text + "\n";
}

struct Written {
  const char* file;
  std::string (*write)(const Face&);
};
const std::vector<Written> kFormats = {
    {"a.obj", [](const Face& face) { return places(face, "v ") + "f" + corners(face, 1); }},
    {"faces first.obj", [](const Face& face) { return "f" + corners(face, 1) + places(face, "v "); }},
    {"a.off",
     [](const Face& face) {
       return fmt::format("OFF\n{} 1 0\n", face.corners.size()) + places(face, "") +
              fmt::format("{}", face.corners.size()) + corners(face, 0);
     }},
    {"a.ply",
     [](const Face& face) {
       return fmt::format(
                  "ply\nformat ascii 1.0\nelement vertex {}\nproperty float x\nproperty float y\nproperty float z\n"
                  "element face 1\nproperty list uchar int vertex_indices\nend_header\n",
                  face.corners.size()) +
              places(face, "") + fmt::format("{}", face.corners.size()) + corners(face, 0);
     }},
    {"faces first.ply",
     [](const Face& face) {
       return fmt::format(
                  "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement vertex {}\n"
                  "property float x\nproperty float y\nproperty float z\nend_header\n{}",
                  face.corners.size(), face.corners.size()) +
              corners(face, 0) + places(face, "");
     }},
};

/// Of all triangles, none taken from another.
double areaOf(const clay::TriangleMesh& mesh) {
  double area = 0;
  for (const auto& [a, b, c] : mesh.triangles)
    area += (mesh.positions[b] - mesh.positions[a]).cross(mesh.positions[c] - mesh.positions[a]).norm() / 2;
  return area;
}

TEST(Polygons, AreCoveredOnceInEveryFormat) {
  const samples::Folder folder;
  for (const Face& face : faces()) {
    for (const Written& format : kFormats) {
      SCOPED_TRACE(fmt::format("{} in {}", face.name, format.file));
      samples::spill(folder / format.file, format.write(face));
      const MeshFile file = readMesh(folder / format.file);
      EXPECT_EQ(file.mesh.triangles.size(), face.corners.size() - 2);
      EXPECT_EQ(file.polygons, 1u);
      EXPECT_NEAR(areaOf(file.mesh), face.area, 1e-9);
      EXPECT_TRUE(file.notes.empty());
      // Written on into a format of triangles.
      ModelObject object;
      object.mesh = file.mesh;
      writeModel(folder / "on.3mf", {std::span(&object, 1)});
      EXPECT_NEAR(areaOf(readMesh(folder / "on.3mf").mesh), face.area, 1e-6);
    }
  }
}

TEST(Polygons, KeepColoursAndObjectsOfTheirFace) {
  const MeshFile off = parseMesh(samples::bytesOf("OFF\n7 2 0\n0 0 0\n4 0 0\n1 1 0\n0 4 0\n5 0 0\n6 0 0\n5 1 0\n"
                                                  "4 0 1 2 3 255 0 0\n3 4 5 6 0 0 255\n"),
                                 "a.off");
  EXPECT_EQ(off.triangleColours, (std::vector<Colour>{{255, 0, 0}, {255, 0, 0}, {0, 0, 255}}));
  const ModelFile obj = parseModel(samples::bytesOf("o dart\nf 1 2 3 4\no other\nf 5 6 7\nv 0 0 0\nv 4 0 0\nv 1 1 0\n"
                                                    "v 0 4 0\nv 5 0 0\nv 6 0 0\nv 5 1 0\n"),
                                   "a.obj");
  ASSERT_EQ(obj.objects.size(), 2u);
  EXPECT_NEAR(areaOf(obj.objects[0].mesh), 4, 1e-12);
  EXPECT_NEAR(areaOf(obj.objects[1].mesh), 0.5, 1e-12);
}

TEST(Polygons, WhatCrossesItselfIsTold) {
  const Face bow{"bow tie", {{0, 0, 0}, {2, 2, 0}, {2, 0, 0}, {0, 2, 0}}, 0};
  for (const Written& format : kFormats) {
    const MeshFile file = parseMesh(samples::bytesOf(format.write(bow)), format.file);
    EXPECT_EQ(file.mesh.triangles.size(), 2u);
    EXPECT_EQ(file.notes, (std::vector<std::string>{"1 face crosses itself: parts may be missing or covered twice; "
                                                    "repair the model in the program that made it"}));
  }
}

}  // namespace
}  // namespace argil::io
