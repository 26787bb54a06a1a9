// STEP and IGES read in the confined process, where OpenCASCADE is there.

#include <gmock/gmock.h>

#include <cmath>
#include <cstdlib>
#include <fstream>
#include <numbers>

#include "clay/base/error.h"
#include "clay/cage/fit_cage.h"
#include "clay/field/primitives.h"
#include "clay/mesh/mesh_topology.h"
#include "clay/mesh/weld.h"
#include "clay/store/store.h"
#include "io/cad/iges_file.h"
#include "io/cad/step_file.h"
#include "io/models/model_file.h"
#include "io/models/reader_process.h"
#include "tests/support/iges_samples.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/step_samples.h"

namespace argil::io {
namespace {

using samples::boxFaces;
using samples::Folder;
using samples::igesOf;
using samples::igesOfSurfaces;
using ::testing::HasSubstr;

class CadFiles : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!readsCad()) GTEST_SKIP() << "this build has no OpenCASCADE";
  }
  std::string written(const std::string& name, const std::string& text) {
    const std::filesystem::path file = folder_ / name;
    std::ofstream(file, std::ios::binary) << text;
    return file.string();
  }
  static std::filesystem::path data(const char* name) {
    const char* folder = std::getenv("ARGIL_DATA");
    return folder ? std::filesystem::path(folder) / "cad" / name : std::filesystem::path();
  }
  static clay::TopologyReport topologyOf(const ModelObject& object) {
    return clay::checkTopology(clay::weldExact(object.mesh));
  }
  Folder folder_;
};

TEST_F(CadFiles, WhatWeWroteComesBackAsItWas) {
  // A ring: one closed solid, whose volume and surface are known.
  clay::Grid grid;
  grid.voxelMm = 0.5;
  const clay::FittedPatches fitted =
      clay::fitPatches(clay::makeTorus(clay::Store::make(), grid, {3, -2, 7}, 25, 9), 200, 1, clay::WorkPart(nullptr));
  for (const bool iges : {false, true}) {
    SCOPED_TRACE(iges);
    const std::filesystem::path file = folder_ / (iges ? "ring.igs" : "ring.step");
    {
      AtomicFile out(file);
      const CadBody body{.name = "A ring", .surface = &fitted.surface, .colour = std::array{0.2f, 0.4f, 0.6f}};
      (iges ? writeIges : writeStep)(out, "ring", std::span(&body, 1), nullptr);
      out.commit();
    }
    const ModelFile model = readModel(file);
    EXPECT_EQ(model.format, iges ? "IGES" : "STEP");
    EXPECT_EQ(model.unitMm, 1.0);
    EXPECT_TRUE(model.notes.empty()) << "nothing had to be sewn: " << model.notes[0];
    ASSERT_EQ(model.objects.size(), 1u);
    EXPECT_EQ(model.objects[0].name, "A ring");
    EXPECT_EQ(model.objects[0].colour, (Colour{51, 102, 153, 255}));
    const clay::TopologyReport topology = topologyOf(model.objects[0]);
    EXPECT_TRUE(topology.solid());
    EXPECT_EQ(topology.bodies, 1u);
    EXPECT_NEAR(topology.volume / (2 * std::numbers::pi * std::numbers::pi * 25 * 81), 1, 2e-3);
    for (const Vec3d& p : model.objects[0].mesh.positions) {
      const Vec3d q = p - Vec3d(3, -2, 7);
      EXPECT_NEAR(std::hypot(std::hypot(q.x(), q.y()) - 25, q.z()), 9, 0.05);
    }
  }
}

TEST_F(CadFiles, LooseFacesOfIgesBecomeAClosedBody) {
  const ModelFile model = readModel(written("box.igs", igesOf(boxFaces({10, 20, 30}))));
  EXPECT_EQ(model.format, "IGES");
  ASSERT_EQ(model.objects.size(), 1u);
  EXPECT_TRUE(topologyOf(model.objects[0]).solid());
  EXPECT_NEAR(std::abs(topologyOf(model.objects[0]).volume), 6000, 1e-6);
  ASSERT_EQ(model.notes.size(), 1u);
  EXPECT_EQ(model.notes[0], "6 loose faces were sewn together, 0 of their edges stay open");
  // One face fewer: it is told, and what there is is read.
  std::vector<std::array<Vec3d, 4>> open = boxFaces({10, 20, 30});
  open.pop_back();
  const ModelFile torn = readModel(written("open.iges", igesOf(open)));
  EXPECT_THAT(torn.notes.at(0), HasSubstr("5 loose faces were sewn together, 4 of their edges"));
  EXPECT_FALSE(topologyOf(torn.objects.at(0)).solid());
}

TEST_F(CadFiles, PlanesAndCylindersAreRead) {
  const ModelFile model = readModel(written("block.step", samples::stepOfBoredBlock({20, 30, 10}, 6)));
  ASSERT_EQ(model.objects.size(), 1u);
  EXPECT_EQ(model.objects[0].name, "Bored block");
  EXPECT_TRUE(model.notes.empty());
  const clay::TopologyReport topology = topologyOf(model.objects[0]);
  EXPECT_TRUE(topology.solid());
  EXPECT_NEAR(topology.volume / (6000 - std::numbers::pi * 360), 1, 2e-4);
}

TEST_F(CadFiles, AByteOrderMarkIsPassedOverOrTold) {
  const std::string mark = "\xef\xbb\xbf", block = samples::stepOfBoredBlock({20, 30, 10}, 6);
  const ModelFile plain = readModel(written("block.step", block)),
                  marked = readModel(written("mark.step", mark + block));
  ASSERT_EQ(marked.objects.size(), 1u);
  EXPECT_EQ(marked.objects[0].name, "Bored block");
  EXPECT_EQ(marked.objects[0].mesh.positions, plain.objects[0].mesh.positions);
  EXPECT_EQ(marked.objects[0].mesh.triangles, plain.objects[0].mesh.triangles);
  const std::filesystem::path iges = written("mark.igs", mark + igesOf(boxFaces({10, 20, 30})));
  EXPECT_THAT(samples::errorOf([&] { (void)readModel(iges); }), HasSubstr("save it as plain ASCII"));
}

TEST_F(CadFiles, ColoursOfBodiesAndFacesAreKept) {
  const Colour red{255, 0, 0, 255}, green{0, 255, 0, 255}, blue{0, 0, 255, 255};
  // Two blocks of one part that touch, red and green, with one blue side each and a blue bore in the second.
  samples::StepPart part;
  part.blocks = {Vec3d::Zero(), {20, 0, 0}};
  part.bodies = {{1, 0, 0}, {0, 1, 0}};
  part.faces = {{1, {0, 0, 1}}, {8, {0, 0, 1}}, {13, {0, 0, 1}}};
  const ModelFile model = readModel(written("two.step", samples::stepOfBoredBlock({20, 30, 10}, 6, part)));
  ASSERT_EQ(model.objects.size(), 1u);
  const ModelObject& object = model.objects[0];
  // As it is, not welded: they share no vertex.
  const clay::TopologyReport topology = clay::checkTopology(object.mesh);
  EXPECT_TRUE(topology.solid());
  EXPECT_EQ(topology.bodies, 2u);
  ASSERT_EQ(object.triangleColours.size(), object.mesh.triangles.size());
  for (size_t t = 0; t < object.mesh.triangles.size(); ++t) {
    const auto& [a, b, c] = object.mesh.triangles[t];
    const Vec3d middle = (object.mesh.positions[a] + object.mesh.positions[b] + object.mesh.positions[c]) / 3;
    if (std::abs(middle.x() - 20) < 1e-9) continue;  // where they touch
    const bool second = middle.x() > 20;
    const bool top = std::abs(middle.z() - 10) < 1e-9;
    const bool bore = std::hypot(middle.x() - 30, middle.y() - 15) < 6.1 && middle.z() > 1e-9 && !top;
    EXPECT_EQ(object.triangleColours[t], top || bore ? blue : second ? green : red) << middle.transpose();
  }
}

TEST_F(CadFiles, OneColourOfAllFacesIsThatOfTheWhole) {
  samples::StepPart part;
  for (size_t face = 0; face < 7; ++face) part.faces[face] = {0, 0, 1};
  const ModelFile all = readModel(written("all.step", samples::stepOfBoredBlock({20, 30, 10}, 6, part)));
  EXPECT_EQ(all.objects.at(0).colour, (Colour{0, 0, 255, 255}));
  EXPECT_TRUE(all.objects[0].triangleColours.empty());
  // One face fewer: it is white, as parts without a colour are.
  part.faces.erase(6);
  const ModelFile most = readModel(written("most.step", samples::stepOfBoredBlock({20, 30, 10}, 6, part)));
  EXPECT_FALSE(most.objects.at(0).colour);
  const std::vector<Colour>& colours = most.objects[0].triangleColours;
  ASSERT_EQ(colours.size(), most.objects[0].mesh.triangles.size());
  EXPECT_EQ(
      std::ranges::count(colours, Colour{255, 255, 255, 255}) + std::ranges::count(colours, Colour{0, 0, 255, 255}),
      std::ssize(colours));
  EXPECT_GT(std::ranges::count(colours, Colour{255, 255, 255, 255}), 20);
}

TEST_F(CadFiles, ColoursOfLooseFacesAreKept) {
  const ModelFile model = readModel(written("box.igs", igesOf(boxFaces({10, 20, 30}), {2, 3, 4, 4, 4, 4})));
  ASSERT_EQ(model.objects.size(), 1u);
  const ModelObject& object = model.objects[0];
  EXPECT_TRUE(clay::checkTopology(object.mesh).solid());
  ASSERT_EQ(object.triangleColours.size(), 12u);
  for (size_t t = 0; t < 12; ++t) {
    const auto& [a, b, c] = object.mesh.triangles[t];
    const double height = (object.mesh.positions[a] + object.mesh.positions[b] + object.mesh.positions[c]).z() / 3;
    const Colour& colour = object.triangleColours[t];
    EXPECT_EQ(colour.red > 200, std::abs(height) < 1e-6) << height;
    EXPECT_EQ(colour.green > 200, std::abs(height - 30) < 1e-6) << height;
  }
}

TEST_F(CadFiles, FacesSayWhereTheyLie) {
  const Vec3d size(20, 30, 10);
  const ModelFile model = readModel(written("block.step", samples::stepOfBoredBlock(size, 6)));
  ASSERT_EQ(model.objects.size(), 1u);
  int planes = 0, axes = 0;
  for (const ModelFace& face : model.objects[0].faces) {
    EXPECT_NEAR(face.along.dot(face.across), 0, 1e-12);
    if (face.kind == ModelFace::Kind::axis) {
      ++axes;
      EXPECT_LT((face.at - size / 2).norm(), 1e-9);
      EXPECT_NEAR(std::abs(face.along.z()), 1, 1e-12);
      EXPECT_NEAR(face.width, 10, 1e-9);
      EXPECT_NEAR(face.depth, 6, 1e-9);
      continue;
    }
    ++planes;
    ASSERT_EQ(face.kind, ModelFace::Kind::plane);
    // Its middle is that of a side of the block, and it looks away from the block's middle.
    int axis = 0;
    face.along.cwiseAbs().maxCoeff(&axis);
    EXPECT_NEAR((face.at - size / 2).dot(face.along), size[axis] / 2, 1e-9);
    EXPECT_LT(((face.at - size / 2) - (face.at - size / 2).dot(face.along) * face.along).norm(), 1e-9);
    EXPECT_NEAR(face.width * face.depth, size.prod() / size[axis], 1e-6);
    int side = 0;
    face.across.cwiseAbs().maxCoeff(&side);
    EXPECT_NEAR(face.width, size[side], 1e-9);
  }
  EXPECT_EQ(planes, 6);
  EXPECT_EQ(axes, 1);
}

// Many programs write all surfaces as splines, a cylinder in two halves.
TEST_F(CadFiles, SplinesThatArePlainFormsSayWhereTheyLie) {
  const Eigen::AngleAxisd turn(0.7, Vec3d(1, 2, -1).normalized());
  const Vec3d place(40, -25, 13);
  const double half = std::sqrt(0.5);
  const auto placed = [&](samples::IgesSurface surface) {
    for (Vec3d& p : surface.points) p = turn * p + place;
    return surface;
  };
  const std::vector<double> line{0, 0, 1, 1}, arc{0, 0, 0, 1, 1, 1}, cubic{0, 0, 0, 0, 1, 1, 1, 1};
  struct Case {
    const char* what;
    samples::IgesSurface surface;
    std::optional<ModelFace> face;  // before it is placed
  };
  const auto axis = [](double z, double length, double radius) {
    ModelFace face;
    face.kind = ModelFace::Kind::axis, face.at = {0, 0, z}, face.along = Vec3d::UnitZ();
    face.width = length, face.depth = radius;
    return face;
  };
  ModelFace middle = axis(0, 12, 12), plane = axis(0, 7, 4);
  middle.kind = ModelFace::Kind::middle, plane.kind = ModelFace::Kind::plane;
  samples::IgesSurface flat,
      free = samples::halfTurned(3, cubic, {{9, 0, 0}, {12, 0, 5}, {7, 0, 9}, {9, 0, 15}}, {1, 1, 1, 1});
  samples::IgesSurface drawn = free, screw = free;
  flat.points = {{-3.5, -2, 0}, {3.5, -2, 0}, {-3.5, 2, 0}, {3.5, 2, 0}}, flat.weights = {1, 1, 1, 1};
  free.points[7] += Vec3d(0.1, 0, 0);
  // Rows that are the first one moved along a line: nothing turns there.
  for (size_t i = 0; i < drawn.points.size(); ++i)
    drawn.points[i] = Vec3d(double(i % 5) * 4, double(i % 5 == 2) * 5 + double(i % 5 == 3) * 2, double(i / 5) * 6);
  // Rows that are turned about z and lifted: a screw, nearly.
  for (size_t i = 0; i < screw.points.size(); ++i) {
    const double angle = 0.02 * double(i / 5);
    screw.points[i] = Eigen::AngleAxisd(angle, Vec3d::UnitZ()) * Vec3d(3 + double(i % 5) * 2, double(i % 5 == 2), 0) +
                      Vec3d(0, 0, angle * 80);
  }
  const std::vector<Case> cases{
      {"plane", flat, plane},
      {"cylinder", samples::halfTurned(1, line, {{6, 0, 2}, {6, 0, 12}}, {1, 1}), axis(7, 10, 6)},
      {"cone", samples::halfTurned(1, line, {{6, 0, 2}, {2, 0, 12}}, {1, 1}), axis(7, 10, 4)},
      {"ball", samples::halfTurned(2, arc, {{12, 0, 0}, {12, 0, 12}, {0, 0, 12}}, {1, half, 1}), middle},
      {"ring", samples::halfTurned(2, arc, {{12, 0, 0}, {12, 0, 4}, {8, 0, 4}}, {1, half, 1}), axis(2, 4, 10.5)},
      {"vase", samples::halfTurned(3, cubic, {{9, 0, 0}, {12, 0, 5}, {7, 0, 9}, {9, 0, 15}}, {1, 1, 1, 1}),
       axis(7.5, 15, 9.4)},
      {"free", free, std::nullopt},
      {"drawn along a line", drawn, std::nullopt},
      {"screw", screw, std::nullopt}};
  for (const Case& each : cases) {
    SCOPED_TRACE(each.what);
    // A large face beside it, as a model is larger than each of its faces.
    samples::IgesSurface base;
    base.points = {{-60, -60, -60}, {60, -60, -60}, {-60, 60, -60}, {60, 60, -60}}, base.weights = {1, 1, 1, 1};
    const ModelFile model = readModel(written("form.igs", igesOfSurfaces({placed(each.surface), base})));
    ASSERT_EQ(model.objects.size(), 1u);
    std::vector<ModelFace> found;
    for (const ModelFace& face : model.objects[0].faces)
      if ((face.at - Vec3d(0, 0, -60)).norm() > 1e-6) found.push_back(face);
    ASSERT_EQ(found.size(), each.face ? 1u : 0u);
    if (!each.face) continue;
    const ModelFace& face = found[0];
    EXPECT_EQ(face.kind, each.face->kind);
    EXPECT_LT((face.at - (turn * each.face->at + place)).norm(), 1e-6);
    if (face.kind != ModelFace::Kind::middle) {
      EXPECT_NEAR(std::abs(face.along.dot(turn * each.face->along)), 1, 1e-9);
    }
    EXPECT_NEAR(face.along.dot(face.across), 0, 1e-9);
    EXPECT_NEAR(face.width, each.face->width, 0.02 * each.face->width);
    EXPECT_NEAR(face.depth, each.face->depth, 0.1 * each.face->depth);
  }
}

// Of other programs: the planes that are told hold points of the mesh, with all of it on one side or not.
TEST_F(CadFiles, FacesOfOtherProgramsHoldTheirMesh) {
  if (!std::filesystem::exists(data("featuretype.STEP"))) GTEST_SKIP() << "ARGIL_DATA is not set";
  for (const char* name : {"featuretype.STEP", "screw.step"}) {
    const ModelFile model = readModel(data(name));
    for (const ModelObject& object : model.objects) {
      EXPECT_GT(object.faces.size(), 3u) << name;
      for (const ModelFace& face : object.faces) {
        // Places of the mesh that lie on the face's plane, or on its cylinder within the length that is told.
        size_t on = 0;
        for (const Vec3d& p : object.mesh.positions) {
          const double h = (p - face.at).dot(face.along), r = (p - face.at - h * face.along).norm();
          on += face.kind == ModelFace::Kind::plane ? std::abs(h) < 1e-3 : std::abs(h) < face.width / 2 + 1e-3 && r > 0;
        }
        EXPECT_GE(on, 3u) << name << " " << int(face.kind);
      }
    }
  }
}

TEST_F(CadFiles, PartsOfOtherProgramsAreRead) {
  if (!std::filesystem::exists(data("featuretype.STEP"))) GTEST_SKIP() << "ARGIL_DATA is not set";
  const ModelFile part = readModel(data("featuretype.STEP"));
  ASSERT_EQ(part.objects.size(), 1u);
  EXPECT_EQ(part.objects[0].name, "featuretype");
  EXPECT_TRUE(topologyOf(part.objects[0]).solid());
  EXPECT_NEAR(topologyOf(part.objects[0]).volume / 190500, 1, 1e-3);
  ASSERT_TRUE(part.objects[0].colour);
  EXPECT_EQ(part.objects[0].colour->red, 202);
  const ModelFile screw = readModel(data("screw.step"));
  EXPECT_NEAR(topologyOf(screw.objects.at(0)).volume / 3788, 1, 1e-3);
  const ModelFile bearing = readModel(data("bearing.iges"));
  EXPECT_THAT(bearing.notes.at(0), HasSubstr("213 loose faces were sewn together, "));
}

TEST(CadFilesWithoutOpenCascade, AreCalledByTheirName) {
  const Folder folder;
  std::ofstream(folder / "a.step") << "ISO-10303-21;\nHEADER;";
  setenv("ARGIL_READER", (folder / "none").c_str(), 1);
  try {
    (void)readModel(folder / "a.step");
    ADD_FAILURE();
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("is a CAD model, which is read by OpenCASCADE"));
  }
  unsetenv("ARGIL_READER");
}

TEST_F(CadFiles, WhatIsNoneIsOneSentence) {
  const auto refuses = [&](const std::string& file, const std::string& why) {
    try {
      (void)readModel(file);
      ADD_FAILURE() << file;
    } catch (const Error& error) {
      EXPECT_THAT(error.what(), HasSubstr(why));
      EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos);
    }
  };
  refuses(written("empty.step", "ISO-10303-21;\nHEADER;\nENDSEC;\nDATA;\nENDSEC;\nEND-ISO-10303-21;\n"), "STEP");
  refuses(written("cut.step", "ISO-10303-21;\nHEADER;\nFILE_DESCRIPTION(("), "STEP");
  refuses(written("none.iges", igesOf({})), "");
  refuses(written("point.step", samples::stepOfBoredBlock({1, 1, 1}, 0.1, {.blocks = {}, .bodies = {}, .faces = {}})),
          "holds no faces");
  Job job;
  job.cancel();
  EXPECT_THROW((void)readModel(written("box.iges", igesOf(boxFaces({1, 2, 3}))), &job), Cancelled);
}

}  // namespace
}  // namespace argil::io
