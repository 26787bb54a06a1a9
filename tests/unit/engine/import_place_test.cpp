// How a model that was read stands in the world, where its file does not say it.

#include "engine/models/import_place.h"

#include <gtest/gtest.h>

namespace argil::engine {
namespace {

// A pyramid on the ground, whose tip points along an axis of the file, its size in any unit.
std::shared_ptr<io::ModelFile> pyramid(int tip, double size) {
  auto model = std::make_shared<io::ModelFile>();
  io::ModelObject& object = model->objects.emplace_back();
  const int u = (tip + 1) % 3, v = (tip + 2) % 3;
  for (int i = 0; i < 4; ++i) {
    Vec3d corner = Vec3d::Zero();
    corner[u] = i == 1 || i == 2 ? size : -size;
    corner[v] = i >= 2 ? size : -size;
    object.mesh.positions.push_back(corner);
  }
  Vec3d top = Vec3d::Zero();
  top[tip] = 3 * size;
  object.mesh.positions.push_back(top);
  object.mesh.triangles = {{0, 2, 1}, {0, 3, 2}, {0, 1, 4}, {1, 2, 4}, {2, 3, 4}, {3, 0, 4}};
  return model;
}

// The base tells, against what is usual for the kind of file, in whatever unit the file is.
TEST(ImportPlace, StandsOnItsBaseWhateverItsUnit) {
  for (const double size : {1e-4, 1.0, 1e4}) {
    for (const char* file : {"a.stl", "a.obj"}) {
      EXPECT_EQ(lookAtModel(pyramid(2, size), file).up, UpAxis::z) << file << " " << size;
      EXPECT_EQ(lookAtModel(pyramid(1, size), file).up, UpAxis::y) << file << " " << size;
    }
    // Neither axis has a base: as is usual.
    EXPECT_EQ(lookAtModel(pyramid(0, size), "a.stl").up, UpAxis::z) << size;
    EXPECT_EQ(lookAtModel(pyramid(0, size), "a.obj").up, UpAxis::y) << size;
  }
}

}  // namespace
}  // namespace argil::engine
