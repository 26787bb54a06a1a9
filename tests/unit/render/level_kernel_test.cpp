// Levels of detail that the device makes are those that the CPU makes: the same triangles, the same picture.

#include <random>
#include <set>

#include "clay/base/error.h"
#include "clay/surface/vertex_channels.h"
#include "render/surface/surface_layout.h"
#include "tests/unit/render/picture_fixture.h"

namespace argil::render {
namespace {

using test::FieldSurface;

constexpr int kWidth = 320, kHeight = 200;

/// Curved, flat, thin and cut: with a plate a voxel and a half thick and a bar.
double shape(const Vec3d& p) {
  const double ball = (p - Vec3d(-6, 2, 1)).norm() - 17.3;
  const Vec3d q = (p - Vec3d(8, 3, 0)).cwiseAbs() - Vec3d(22, 0.75, 18);
  const Vec3d r = (p - Vec3d(0, 0, -4.5)).cwiseAbs() - Vec3d(3.2, 26, 3.7);
  return std::min({ball, q.maxCoeff(), r.maxCoeff()});
}

/// One renderer that makes levels on its device, one that makes them on the CPU; both get the same.
class LevelKernels : public testing::Test {
 protected:
  void SetUp() override {
    if (devices().empty()) GTEST_SKIP() << "no Vulkan driver on this machine: pictures cannot be drawn";
    for (const auto levels : {RendererOptions::Levels::device, RendererOptions::Levels::cpu}) {
      RendererOptions options;
      options.validation = true;
      options.levels = levels;
      renderers_.emplace_back(options);
    }
  }
  void TearDown() override {
    for (Renderer& renderer : renderers_)
      for (const std::string& message : renderer.validationMessages()) ADD_FAILURE() << message;
  }

  void update(const test::Field& field, PieceId piece = 0, const Vec3d& originMm = Vec3d::Zero(),
              const clay::VertexPaint* paint = nullptr) {
    clay::Grid grid;
    grid.voxelMm = 0.5;
    grid.originMm = originMm;
    clay::SurfaceDelta delta = surfaces_[piece].update(grid, {-4, -4, -4}, {3, 3, 3}, field);
    for (size_t i = 0; paint && i < delta.changed.size(); i += 3) {
      auto one = std::make_shared<clay::BrickPaint>();
      one->brick = delta.changed[i]->brick;
      one->vertices.assign(delta.changed[i]->positions.size(), *paint);
      for (size_t n = 0; n < one->vertices.size(); ++n) one->vertices[n].green = uint8_t(7 * n);
      delta.painted.push_back(std::move(one));
    }
    for (Renderer& renderer : renderers_) renderer.update(piece, delta);
  }
  void place(PieceId piece, const PieceLook& look) {
    for (Renderer& renderer : renderers_) renderer.place(piece, look);
  }

  /// From near and from far, until every level is there.
  void expectSamePictures(const char* when) {
    constexpr int kRest = 12;
    for (const double times : {1.0, 6.0, 9.0, 13.0, 24.0}) {
      View view = View::named("iso", renderers_[1].bounds(), double(kWidth) / kHeight, Projection::perspective);
      view.position = view.target + times * (view.position - view.target);
      std::array<Image, 2> images;
      std::array<Renderer::DrawStats, 2> stats;
      for (size_t i = 0; i < 2; ++i) {
        for (int n = 0; n < kRest; ++n) {
          images[i] = renderers_[i].render(Shot{view, {}, {}, {}}, kWidth, kHeight);
          levelBytes_[i] += renderers_[i].drawStats().levelBytes;
        }
        stats[i] = renderers_[i].drawStats();
        EXPECT_EQ(stats[i].levelBytes, 0u) << when << ": not at rest";
      }
      EXPECT_EQ(images[0], images[1]) << when << ", from " << times << " times as far";
      EXPECT_EQ(stats[0].trianglesDrawn, stats[1].trianglesDrawn) << when;
      EXPECT_EQ(stats[0].chunksDrawn, stats[1].chunksDrawn) << when;
      EXPECT_EQ(stats[0].chunksCulled, stats[1].chunksCulled) << when;
      drawn_.insert(stats[0].trianglesDrawn);
    }
  }

  std::vector<Renderer> renderers_;
  std::array<FieldSurface, 2> surfaces_;
  std::array<uint64_t, 2> levelBytes_{};
  std::set<uint64_t> drawn_;  // triangles of a picture
};

TEST_F(LevelKernels, DrawWhatTheCpusDraw) {
  update(shape);
  expectSamePictures("a first load");
  EXPECT_EQ(drawn_.size(), size_t(kLevels)) << "each level was drawn";
  EXPECT_GT(levelBytes_[0], 0u);
  EXPECT_LT(levelBytes_[0], levelBytes_[1] / 4) << "only tables are sent";

  // Strokes move bricks within the buffers and leave empty triangles.
  constexpr unsigned kSeed = 3;
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> place(-20, 20), size(3, 9);
  std::vector<std::pair<Vec3d, double>> dents;
  const auto dented = [&](const Vec3d& p) {
    double most = shape(p);
    for (const auto& [at, radius] : dents) most = std::max(most, radius - (p - at).norm());
    return most;
  };
  for (int stroke = 0; stroke < 4; ++stroke) {
    for (int n = 0; n < 3; ++n) dents.emplace_back(Vec3d(place(random), place(random), place(random)), size(random));
    update(dented);
  }
  expectSamePictures("after strokes");
}

TEST_F(LevelKernels, SamePaintHiddenClayAndSeveralPieces) {
  const clay::VertexPaint red{200, 0, 30, 255, 0, 0}, unseen{0, 0, 0, 0, kUnseenMaterial, 0},
      masked{0, 90, 0, 200, 0, 255};
  update(shape, 0, Vec3d::Zero(), &red);
  update([](const Vec3d& p) { return p.norm() - 21; }, 1, {30, 4, -6}, &masked);
  PieceLook look;
  look.rotation = Eigen::AngleAxisd(0.7, Vec3d(1, 2, 3).normalized());
  place(1, look);
  expectSamePictures("two pieces, painted");
  look.hideMasked = true;
  place(1, look);
  update([](const Vec3d& p) { return std::max(shape(p), 8 - (p - Vec3d(10, 3, 0)).norm()); }, 0, Vec3d::Zero(),
         &unseen);
  expectSamePictures("some of it hidden");
}

TEST_F(LevelKernels, ALostDeviceIsSeenAndComesBackWithThem) {
  update(shape);
  expectSamePictures("before");
  View view = View::named("iso", renderers_[1].bounds(), double(kWidth) / kHeight, Projection::perspective);
  view.position = view.target + 16 * (view.position - view.target);  // wants levels that are not there
  update([](const Vec3d& p) { return std::max(shape(p), 6 - (p - Vec3d(-20, 0, 0)).norm()); });
  for (Renderer& renderer : renderers_) {
    for (int n = 0; n < 8; ++n) static_cast<void>(renderer.render(Shot{view, {}, {}, {}}, kWidth, kHeight));
    renderer.simulateDeviceLoss();
    EXPECT_THROW(static_cast<void>(renderer.render(Shot{view, {}, {}, {}}, kWidth, kHeight)), Error);
    EXPECT_TRUE(renderer.deviceLost());
    renderer.recover();
  }
  surfaces_ = {};
  update(shape);
  expectSamePictures("on a new device");
}

TEST_F(LevelKernels, AreNeverWrongWhereThereIsNoRoomForThem) {
  RendererOptions options;
  options.levels = RendererOptions::Levels::device;
  Renderer free(options);
  FieldSurface surface;
  clay::Grid grid;
  grid.voxelMm = 0.5;
  const auto delta = surface.update(grid, {-4, -4, -4}, {3, 3, 3}, shape);
  free.update(delta);
  View view = View::named("iso", free.bounds(), double(kWidth) / kHeight, Projection::perspective);
  view.position = view.target + 9 * (view.position - view.target);
  const Shot shot{view, {}, {}, {}};
  Image coarse = free.render(shot, kWidth, kHeight);
  const uint64_t coarseTriangles = free.drawStats().trianglesDrawn;
  options.quality.detailPixels = 0;
  Renderer fine(options);
  fine.update(delta);
  Image all;
  for (int n = 0; n < 4; ++n) all = fine.render(shot, kWidth, kHeight);
  const uint64_t allBytes = fine.deviceBytes();
  // From just enough for the finest to enough for all.
  bool refused = false, made = false;
  for (uint64_t room = 0; room < 400'000; room += 50'000) {
    options.quality.detailPixels = 1;
    options.memoryLimitBytes = allBytes + room;
    Renderer tight(options);
    tight.update(delta);
    Image image;
    for (int n = 0; n < 4; ++n) image = tight.render(shot, kWidth, kHeight);
    const uint64_t drawn = tight.drawStats().trianglesDrawn;
    refused |= drawn > coarseTriangles;
    made |= drawn == coarseTriangles;
    if (drawn == coarseTriangles) {
      EXPECT_EQ(image, coarse) << room;
    }
    EXPECT_LT(test::meanDifference(image, all), 3) << room;
  }
  EXPECT_TRUE(refused);
  EXPECT_TRUE(made);
}

}  // namespace
}  // namespace argil::render
