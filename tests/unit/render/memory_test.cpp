// What happens when the device's memory ends.

#include <gtest/gtest.h>

#include <optional>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"
#include "render/renderer/renderer.h"
#include "tests/unit/render/field_surface.h"

namespace argil::render {
namespace {

class Memory : public testing::Test {
 protected:
  static constexpr int kWidth = 160, kHeight = 120;

  void SetUp() override {
    if (devices().empty()) GTEST_SKIP() << "no Vulkan driver on this machine: pictures cannot be drawn";
    start(0);
    load(*renderer_, 0, 16);
    for (int i = 0; i < 4; ++i) free_ = draw();  // until what frames take turns with is there
    const uint64_t enough = renderer_->deviceBytes();
    finish();
    start(enough + (64 << 10));
    load(*renderer_, 0, 16);
    for (int i = 0; i < 4; ++i) EXPECT_EQ(draw(), free_);
  }
  void TearDown() override { finish(); }
  void finish() {
    if (!renderer_) return;
    for (const std::string& message : renderer_->validationMessages()) ADD_FAILURE() << message;
    renderer_.reset();
  }
  void start(uint64_t limit) {
    RendererOptions options;
    options.validation = true;
    options.quality.supersample = 1;
    options.quality.shadowPixels = 256;
    options.memoryLimitBytes = limit;
    renderer_.emplace(options);
  }
  static void load(Renderer& renderer, PieceId piece, double radius) {
    test::FieldSurface surface;
    clay::Grid grid;
    grid.voxelMm = 0.5;
    renderer.update(piece,
                    surface.update(grid, {-3, -3, -3}, {2, 2, 2}, [&](const Vec3d& p) { return p.norm() - radius; }));
  }
  Image draw() { return renderer_->render(Shot(), kWidth, kHeight); }
  template <class Work>
  void expectOutOfMemory(Work&& work) {
    try {
      work();
      ADD_FAILURE() << "there was room";
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find("memory"), std::string::npos) << error.what();
      EXPECT_EQ(error.kind(), Error::Kind::work);
    }
    EXPECT_FALSE(renderer_->deviceLost());
  }

  Image free_;
  std::optional<Renderer> renderer_;
};

TEST_F(Memory, AModelThatDoesNotFitLeavesTheOthers) {
  clay::TriangleMesh large;
  for (int i = 0; i < 60'000; ++i) {
    const double x = i % 300, y = i / 300;
    for (const Vec3d& corner : {Vec3d(x, y, 0), Vec3d(x + 1, y, 0), Vec3d(x, y + 1, 0)})
      large.positions.push_back(corner);
    large.triangles.push_back({uint32_t(3 * i), uint32_t(3 * i + 1), uint32_t(3 * i + 2)});
  }
  for (int i = 0; i < 3; ++i) {
    expectOutOfMemory([&] { renderer_->updatePart(5, large); });
    EXPECT_EQ(draw(), free_);
  }
  // What is small enough still finds its place, and all of it is drawn.
  PieceLook aside;
  aside.translationMm = {12, 0, 0};
  const auto addSmall = [&] {
    load(*renderer_, 1, 4);
    renderer_->place(1, aside);
    return draw();
  };
  const Image with = addSmall();
  EXPECT_NE(with, free_);
  finish();
  start(0);
  load(*renderer_, 0, 16);
  EXPECT_EQ(addSmall(), with);
}

TEST_F(Memory, APictureThatDoesNotFitLeavesSmallerOnes) {
  expectOutOfMemory([&] { (void)renderer_->render(Shot(), 2000, 2000); });
  EXPECT_EQ(draw(), free_);
}

TEST_F(Memory, APanelsPictureThatDoesNotFitLeavesTheOthers) {
  const std::vector<uint8_t> pixels(1 << 20, 128);
  expectOutOfMemory([&] { renderer_->setUiTexture(4, 1024, 1024, 1, pixels.data()); });
  UiFrame panels;
  panels.width = panels.height = 1;
  panels.commands.push_back({{0, 0, 1, 1}, 4, 0, 0, 0});
  EXPECT_THROW((void)renderer_->render(Shot(), kWidth, kHeight, &panels), Error);  // it is not there
  EXPECT_EQ(draw(), free_);
}

// What an operation replaced lies there until it comes back, unless another piece has no room then.
TEST_F(Memory, WhatMayComeBackGoesBeforeAPieceDoes) {
  const auto ball = [](double radius) {
    clay::Grid grid;
    grid.voxelMm = 1;
    return clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), radius);
  };
  const clay::Version before = ball(62), after = combine(before, ball(60), clay::Combination::intersect);
  // Bytes with both of an operation, and with a second piece.
  const auto operate = [&](uint64_t limit) {
    finish();
    start(limit);
    clay::Surface surface;
    renderer_->update(1, surface.update(before));
    renderer_->update(1, surface.update(after, 1, true));
    const uint64_t both = renderer_->deviceBytes();
    renderer_->update(2, clay::Surface().update(ball(62)));
    return std::pair(both, renderer_->deviceBytes());
  };
  const auto [held, grown] = operate(0);
  ASSERT_GT(grown, held) << "the second piece fits beside what is kept: this test shows nothing";
  const auto [heldWithin, within] = operate(held + (grown - held) * 17 / 20);
  EXPECT_EQ(heldWithin, held);
  EXPECT_EQ(within, held) << "in the place of what was kept";
}

}  // namespace
}  // namespace argil::render
