// Faces of a CAD model become guides that lie on what the model became.

#include "engine/models/face_guides.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>

#include "engine/models/load_document.h"
#include "engine/models/model_files.h"
#include "engine/text/document_text.h"
#include "io/models/reader_process.h"
#include "tests/support/mesh_samples.h"
#include "tests/support/step_samples.h"

namespace argil::engine {
namespace {

using Kind = io::ModelFace::Kind;
using testing::HasSubstr;

io::ModelFace face(Kind kind, const Vec3d& at, const Vec3d& along, double width, double depth) {
  return {kind, at, along.normalized(), along.unitOrthogonal(), width, depth};
}

io::ModelObject objectOf(const std::string& name, std::vector<io::ModelFace> faces) {
  io::ModelObject object;
  object.name = name;
  object.faces = std::move(faces);
  return object;
}

TEST(FaceGuides, OneForEachPlaneAxisAndMiddleTheLargestFirst) {
  const std::vector<io::ModelObject> objects{
      objectOf("arm", {face(Kind::plane, {0, 0, 5}, {0, 0, 1}, 2, 3), face(Kind::plane, {9, 4, 5}, {0, 0, -1}, 20, 3),
                       face(Kind::plane, {0, 0, 5.01}, {0, 0, 1}, 1, 1),
                       // A bore in two halves and in two steps.
                       face(Kind::axis, {1, 2, 0}, {0, 0, 1}, 4, 2), face(Kind::axis, {1, 2, 9}, {0, 0, -1}, 8, 2),
                       face(Kind::axis, {1, 2.1, 0}, {0, 0, 1}, 4, 2)}),
      objectOf("", {face(Kind::middle, {7, 7, 7}, {1, 0, 0}, 1, 1), face(Kind::middle, {7, 7, 7}, {0, 1, 0}, 3, 3)})};
  const FaceGuides::Made made = FaceGuides(objects).make();
  ASSERT_EQ(made.guides.size(), 5u);
  EXPECT_EQ(made.note, "5 guides of its faces.");
  EXPECT_EQ(made.guides[0].name, "middle 1");  // 4π 9 mm²
  EXPECT_EQ(made.guides[0].kind, Guide::Kind::point);
  EXPECT_EQ(made.guides[1].name, "arm: axis 1");
  EXPECT_EQ(made.guides[1].kind, Guide::Kind::line);
  EXPECT_LT((made.guides[1].pose.translation - Vec3d(1, 2, 9)).norm(), 1e-12);
  EXPECT_NEAR(made.guides[1].sizeMm.z(), 1.2 * 8, 1e-12);
  EXPECT_NEAR(std::abs(made.guides[1].axis().z()), 1, 1e-12);
  EXPECT_EQ(made.guides[2].name, "arm: plane 1");
  EXPECT_NEAR(made.guides[2].sizeMm.x(), 20, 1e-12);
  EXPECT_LT((made.guides[2].axis() - Vec3d(0, 0, -1)).norm(), 1e-12);
  EXPECT_EQ(made.guides[3].name, "arm: axis 2");
  EXPECT_EQ(made.guides[4].name, "arm: plane 2");
  for (const Guide& guide : made.guides) EXPECT_EQ(guide.feel, Guide::Feel::seen);
}

TEST(FaceGuides, ManyAreNotAllShown) {
  std::vector<io::ModelFace> faces;
  for (int i = 0; i < 100; ++i) faces.push_back(face(Kind::plane, {0, 0, double(i)}, {0, 0, 1}, 1 + i, 1));
  const FaceGuides::Made made = FaceGuides({objectOf("rack", faces)}).make();
  ASSERT_EQ(made.guides.size(), FaceGuides::kMost);
  EXPECT_EQ(made.note, "24 guides of its largest faces, of 100.");
  EXPECT_NEAR(made.guides.front().pose.translation.z(), 99, 1e-12);
  EXPECT_NEAR(made.guides.back().pose.translation.z(), 76, 1e-12);
  for (int i = 100; i < 50000; ++i) faces.push_back(face(Kind::plane, {0, 0, double(i)}, {0, 0, 1}, 1 + i, 1));
  EXPECT_EQ(FaceGuides({objectOf("rack", faces)}).make().note, "24 guides of its largest faces, of more than 1000.");
  // What lies where no clay can be gives none.
  EXPECT_TRUE(FaceGuides({objectOf("far", {face(Kind::plane, {0, 1e9, 0}, {0, 0, 1}, 1, 1)})}).make().guides.empty());
  EXPECT_THAT(FaceGuides({objectOf("blob", {})}).make().note, HasSubstr("no plane or round faces"));
}

// However the model is placed, the guides lie on its sides, and are as large.
TEST(FaceGuides, GoWhereTheModelGoes) {
  if (!io::readsCad()) GTEST_SKIP() << "this build has no OpenCASCADE";
  const samples::Folder folder;
  const std::filesystem::path file = folder / "block.step";
  std::ofstream(file, std::ios::binary) << samples::stepOfBoredBlock({20, 30, 10}, 6);
  std::vector<ModelImport> ways(4);
  ways[1].up = "y", ways[1].heightMm = 90, ways[1].stands = true;
  ways[2].fitMm = 45;
  ways[3].voxelMm = 0.5;
  for (ModelImport& how : ways) {
    how.guides = true;
    how.asPart = !how.voxelMm;
    const ImportedModel imported = importModel(file, how);
    ASSERT_EQ(imported.guides.size(), 7u);
    EXPECT_EQ(imported.notes.back().empty(), false);
    if (!how.asPart) {
      ASSERT_EQ(imported.pieces.size(), 1u);
      continue;
    }
    Eigen::AlignedBox3d box;
    for (const Vec3d& p : imported.parts.at(0).mesh->positions) box.extend(p);
    for (const Guide& guide : imported.guides) {
      const Vec3d off = guide.pose.translation - box.center(), half = box.sizes() / 2, normal = guide.axis();
      if (guide.kind == Guide::Kind::line) {
        EXPECT_LT(off.norm(), 1e-6 * half.norm());
        continue;
      }
      const double reach = half.dot(normal.cwiseAbs());
      EXPECT_NEAR(off.dot(normal), reach, 1e-6 * reach);
      EXPECT_LT((off - off.dot(normal) * normal).norm(), 1e-6 * reach);
      EXPECT_NEAR(guide.sizeMm.x() * guide.sizeMm.y(), box.volume() / (2 * reach), 1e-6 * box.volume() / reach);
    }
  }
  EXPECT_TRUE(importModel(file, {.asPart = true}).guides.empty());
  // In a document.
  ModelImport how;
  how.guides = true;
  how.voxelMm = 0.5;
  const LoadedDocument loaded = loadDocument(file, how);
  EXPECT_EQ(loaded.document->guides.size(), 7u);
  EXPECT_EQ(loaded.document->guides[0].name, "Bored block: plane 1");
  EXPECT_THAT(loaded.notes, testing::Contains("7 guides of its faces."));
}

}  // namespace
}  // namespace argil::engine
