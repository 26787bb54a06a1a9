// Several pieces and parts: where they are drawn, what a ray meets, what they leave behind. Drawn through the
// validation layer.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "render/renderer/renderer.h"
#include "tests/unit/render/field_surface.h"

namespace argil::render {
namespace {

constexpr double kRadius = 10;  // mm

clay::SurfaceDelta ball(double voxelMm, double radiusMm = kRadius) {
  clay::Grid grid;
  grid.voxelMm = voxelMm;
  clay::Surface surface;
  return surface.update(clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), radiusMm));
}

/// A plate of two triangles in the plane y = 0, facing −y.
clay::TriangleMesh plate(double half) {
  clay::TriangleMesh mesh;
  mesh.positions = {{-half, 0, -half}, {half, 0, -half}, {half, 0, half}, {-half, 0, half}};
  mesh.triangles = {{0, 1, 2}, {0, 2, 3}};
  return mesh;
}

class ModelPicture : public testing::Test {
 protected:
  static constexpr int kWidth = 320, kHeight = 200;

  void SetUp() override {
    if (devices().empty()) GTEST_SKIP() << "no Vulkan driver on this machine: pictures cannot be drawn";
    start(0);
  }
  void start(double detailPixels) {
    RendererOptions options;
    options.validation = true;
    options.quality = {1, false, 256};
    options.quality.detailPixels = detailPixels;
    renderer_.emplace(options);
  }
  void TearDown() override {
    if (!renderer_) return;
    for (const std::string& message : renderer_->validationMessages()) ADD_FAILURE() << message;
  }
  /// Looking along +y; a pixel is half a millimetre.
  static View front() {
    View view;
    view.position = {0, -500, 0};
    view.projection = Projection::orthographic;
    view.openingDegrees = 2 * std::atan(50.0 / 500) * 180 / std::numbers::pi;
    return view;
  }
  Image draw(const View& view = front()) {
    Shot shot;
    shot.view = view;
    shot.look.grid = shot.look.scaleBar = shot.look.cavity = false;
    return renderer_->render(shot, kWidth, kHeight);
  }
  static bool isClay(const Image& image, int x, int y) {
    const uint8_t* p = image.pixel(x, y);
    return p[0] > p[2] + 8;
  }
  /// Whether clay is drawn at a place in the plane y = 0 of the front view.
  static bool at(const Image& image, double xMm, double zMm) {
    return isClay(image, int(kWidth / 2 + 2 * xMm), int(kHeight / 2 - 2 * zMm));
  }
  static int covered(const Image& image) {
    int count = 0;
    for (int y = 0; y < kHeight; ++y)
      for (int x = 0; x < kWidth; ++x) count += isClay(image, x, y);
    return count;
  }

  std::optional<Renderer> renderer_;
};

TEST_F(ModelPicture, PiecesStandWhereTheyArePlaced) {
  PieceLook left, right;
  left.translationMm = {-40, 0, 0};
  right.translationMm = {40, 0, 10};
  right.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized()));
  renderer_->place(2, right);  // before it comes
  renderer_->update(1, ball(0.5));
  renderer_->update(2, ball(0.25, 0.5 * kRadius));
  renderer_->place(1, left);
  Image image = draw();
  EXPECT_TRUE(at(image, -40, 0));
  EXPECT_TRUE(at(image, -48, 0));
  EXPECT_TRUE(at(image, 40, 10));
  EXPECT_FALSE(at(image, 40, 0));
  EXPECT_FALSE(at(image, 0, 0));
  const double disc = std::numbers::pi * kRadius * kRadius * 4;
  EXPECT_NEAR(covered(image), disc * 1.25, 0.03 * disc);
  EXPECT_GE(renderer_->drawStats().drawCalls, 2u);

  left.visible = false;
  renderer_->place(1, left);
  image = draw();
  EXPECT_FALSE(at(image, -40, 0));
  EXPECT_NEAR(covered(image), disc * 0.25, 0.03 * disc);
  EXPECT_NEAR(renderer_->bounds().min.x(), 35, 0.05);
  EXPECT_TRUE(renderer_->bounds(1).empty());

  renderer_->remove(2);
  EXPECT_EQ(covered(draw()), 0);
  left.visible = true;
  renderer_->place(1, left);
  EXPECT_TRUE(at(draw(), -40, 0));
  renderer_->clear();
  EXPECT_EQ(covered(draw()), 0);
  EXPECT_EQ(renderer_->triangleCount(), 0u);
}

TEST_F(ModelPicture, ATurnedPieceIsLitAsTheWorldLightsIt) {
  // A sphere looks the same however it is turned: positions and normals turn together.
  renderer_->update(ball(0.5));
  const Image straight = draw();
  PieceLook turned;
  turned.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(2.1, Vec3d(-1, 0.4, 0.3).normalized()));
  renderer_->place(0, turned);
  const Image image = draw();
  double difference = 0;
  for (size_t i = 0; i < image.rgba.size(); ++i) {
    difference += std::abs(double(image.rgba[i]) - double(straight.rgba[i]));
  }
  EXPECT_LT(difference / double(image.rgba.size()), 0.4);
  // The test can tell: a normal left behind darkens half of the disc.
  EXPECT_GT(straight.pixel(kWidth / 2 - 10, kHeight / 2 - 10)[0],
            straight.pixel(kWidth / 2 + 12, kHeight / 2 + 12)[0] + 30);
}

TEST_F(ModelPicture, BoundsOfATurnedPieceAreTight) {
  clay::SurfaceDelta cube;
  {
    clay::Grid grid;
    grid.voxelMm = 0.5;
    clay::Surface surface;
    cube = surface.update(clay::makeBlock(clay::Store::make(), grid, Vec3d::Zero(), Vec3d::Constant(20), 0));
  }
  renderer_->update(cube);
  PieceLook look;
  look.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(std::numbers::pi / 4, Vec3d::UnitZ()));
  look.translationMm = {100, 0, 0};
  renderer_->place(0, look);
  const Box box = renderer_->bounds();
  EXPECT_NEAR(box.max.x(), 100 + 10 * std::numbers::sqrt2, 0.6);  // the cube's edges are a voxel round
  EXPECT_NEAR(box.size().z(), 20, 0.1);
  renderer_->update(7, ball(0.5));
  look.translationMm = {-200, 0, 0};
  renderer_->place(7, look);
  EXPECT_NEAR(renderer_->bounds(7).min.x(), -210, 0.02);
  EXPECT_NEAR(renderer_->bounds(7).max.y(), 10, 0.02);
}

TEST_F(ModelPicture, PartsAreSeenFromBothSides) {
  renderer_->updatePart(3, plate(20));
  PieceLook look;
  look.translationMm = {-30, 0, 0};
  renderer_->place(3, look);
  View view = front();
  Image image = draw(view);
  EXPECT_TRUE(at(image, -30, 0));
  EXPECT_TRUE(at(image, -49, 19));
  EXPECT_FALSE(at(image, -30, 21));
  EXPECT_NEAR(covered(image), 80 * 80, 160);
  EXPECT_NEAR(renderer_->bounds().min.x(), -50, 1e-6);
  view.position.y() = 500;
  image = draw(view);
  EXPECT_TRUE(at(image, 30, 0));  // mirrored: seen from behind
  EXPECT_NEAR(covered(image), 80 * 80, 160);

  clay::TriangleMesh bad = plate(5);
  bad.triangles.push_back({0, 1, 9});
  EXPECT_THROW(renderer_->updatePart(3, bad), Error);
  EXPECT_EQ(renderer_->triangleCount(), 2u);
  renderer_->updatePart(3, plate(5));
  EXPECT_NEAR(covered(draw(view)), 20 * 20, 40);
}

TEST_F(ModelPicture, ARayMeetsTheFirstVisiblePiece) {
  renderer_->update(1, ball(0.5));
  renderer_->update(2, ball(0.5));
  renderer_->updatePart(3, plate(20));
  PieceLook look;
  look.translationMm = {0, -30, 0};
  look.rotation = Eigen::Quaterniond(Eigen::AngleAxisd(1.2, Vec3d::UnitX()));
  renderer_->place(2, look);
  PieceLook behind;
  behind.translationMm = {0, 50, 0};
  renderer_->place(3, behind);

  auto hit = renderer_->pick({0.1, -100, 0.2}, {0, 3, 0});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->piece, 2u);
  EXPECT_NEAR(hit->distanceMm, 60, 0.05);
  EXPECT_TRUE(hit->fromOutside);
  EXPECT_GT(hit->normal.dot(-Vec3d::UnitY()), 0.99);
  EXPECT_NEAR(*renderer_->raycast({0.1, -100, 0.2}, {0, 3, 0}), hit->distanceMm, 1e-12);

  look.visible = false;
  renderer_->place(2, look);
  hit = renderer_->pick({0.1, -100, 0.2}, {0, 3, 0});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->piece, 1u);
  EXPECT_NEAR(hit->distanceMm, 90, 0.05);

  // A section that takes the front half away: the back half is met from within.
  Section half;
  half.normal = {0, -1, 0};
  hit = renderer_->pick({0.1, -100, 0.2}, {0, 3, 0}, half);
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->piece, 1u);
  EXPECT_NEAR(hit->distanceMm, 110, 0.05);
  EXPECT_FALSE(hit->fromOutside);
  half.normal = {0, 1, 0};  // what lies behind is taken: the front half is met
  EXPECT_NEAR(renderer_->pick({0.1, -100, 0.2}, {0, 3, 0}, half)->distanceMm, 90, 0.05);
  EXPECT_FALSE(renderer_->pick({0.1, 5, 0.2}, {0, 3, 0}, half));

  hit = renderer_->pick({15, -100, 15}, {0, 1, 0});
  ASSERT_TRUE(hit);
  EXPECT_EQ(hit->piece, 3u);
  EXPECT_NEAR(hit->distanceMm, 150, 1e-3);
  EXPECT_TRUE(hit->fromOutside);
  EXPECT_FALSE(renderer_->pick({15, 100, 15}, {0, -1, 0})->fromOutside);
  EXPECT_FALSE(renderer_->pick({25, -100, 15}, {0, 1, 0}));
}

TEST_F(ModelPicture, NumbersThatAreNotFiniteAreRefused) {
  PieceLook look;
  look.translationMm.x() = std::nan("");
  EXPECT_THROW(renderer_->place(1, look), Error);
  look = {};
  look.rotation.coeffs().setZero();
  EXPECT_THROW(renderer_->place(1, look), Error);
  look = {};
  look.roughness = INFINITY;
  EXPECT_THROW(renderer_->place(1, look), Error);
}

TEST_F(ModelPicture, CoarserLevelsLeaveNoHolesAndKeepTheOutline) {
  const auto fine = ball(0.18);
  renderer_->update(fine);
  View view = front();
  view.projection = Projection::perspective;  // levels differ between chunks
  view.position.y() = -60;
  view.openingDegrees = 60;
  const Image full = draw(view);
  EXPECT_EQ(renderer_->drawStats().trianglesDrawn, renderer_->triangleCount());
  uint64_t triangles = renderer_->triangleCount();
  const double radius = std::sqrt(covered(full) / std::numbers::pi);
  for (const double pixels : {0.5, 1.0, 2.0, 4.0, 8.0}) {
    start(pixels);
    renderer_->update(fine);
    Image image;
    for (int i = 0; i < 4; ++i) image = draw(view);  // levels are made over some pictures
    int holes = 0, outline = 0;
    for (int y = 1; y + 1 < kHeight; ++y) {
      for (int x = 1; x + 1 < kWidth; ++x) {
        if (isClay(image, x, y) == isClay(full, x, y)) continue;
        // Deep in the disc nothing may be missing.
        const double away = std::hypot(x + 0.5 - kWidth / 2, y + 0.5 - kHeight / 2);
        (away < radius - 0.5 - pixels ? holes : outline) += 1;
      }
    }
    EXPECT_EQ(holes, 0) << pixels;
    EXPECT_LE(outline, 0.7 * pixels * 2 * std::numbers::pi * radius) << pixels;
    EXPECT_LE(renderer_->drawStats().trianglesDrawn, triangles) << pixels;
    triangles = renderer_->drawStats().trianglesDrawn;
  }
  EXPECT_LT(triangles, renderer_->triangleCount() / 8);
}

}  // namespace
}  // namespace argil::render
