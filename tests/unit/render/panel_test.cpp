// Panels over a picture, drawn without a window.

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <limits>
#include <optional>

#include "clay/base/error.h"
#include "render/renderer/renderer.h"
#include "tests/unit/render/panel_sample.h"

namespace argil::render {
namespace {

using test::addRectangle;
using test::emptyPanels;
using test::rgba;

class Panels : public testing::Test {
 protected:
  static constexpr int kWidth = 160, kHeight = 120;

  void SetUp() override {
    if (devices().empty()) GTEST_SKIP() << "no Vulkan driver on this machine: pictures cannot be drawn";
    RendererOptions options;
    options.validation = true;
    options.quality.supersample = 1;
    renderer_.emplace(options);
  }
  void TearDown() override {
    if (!renderer_) return;
    for (const std::string& message : renderer_->validationMessages()) ADD_FAILURE() << message;
  }
  Image draw(const UiFrame& panels) { return renderer_->render(Shot(), kWidth, kHeight, &panels); }
  Image bare() { return renderer_->render(Shot(), kWidth, kHeight); }

  static void expectColour(const Image& image, int x, int y, uint32_t colour, int tolerance = 0) {
    const uint8_t* p = image.pixel(x, y);
    for (int i = 0; i < 3; ++i) {
      EXPECT_NEAR(p[i], int(colour >> (8 * i) & 255), tolerance) << "channel " << i << " at " << x << ", " << y;
    }
    EXPECT_EQ(p[3], 255);
  }
  /// Pixels that differ, and how many of them lie in a box.
  static std::array<int, 2> changed(const Image& a, const Image& b, int left, int top, int right, int bottom) {
    std::array<int, 2> count{};
    for (int y = 0; y < a.height; ++y) {
      for (int x = 0; x < a.width; ++x) {
        if (std::equal(a.pixel(x, y), a.pixel(x, y) + 4, b.pixel(x, y))) continue;
        ++count[0];
        count[1] += x >= left && x < right && y >= top && y < bottom;
      }
    }
    return count;
  }

  std::optional<Renderer> renderer_;
};

TEST_F(Panels, OpaqueFacesHaveTheirColourAndTheRestIsThePicture) {
  UiFrame panels = emptyPanels(kWidth, kHeight);
  addRectangle(panels, {10, 20, 50, 60}, rgba(12, 200, 99));
  const Image with = draw(panels), without = bare();
  expectColour(with, 10, 20, rgba(12, 200, 99));
  expectColour(with, 49, 59, rgba(12, 200, 99));
  EXPECT_EQ(changed(with, without, 10, 20, 50, 60), (std::array<int, 2>{40 * 40, 40 * 40}));
}

TEST_F(Panels, BlendInSrgbValues) {
  UiFrame panels = emptyPanels(kWidth, kHeight);
  addRectangle(panels, {0, 0, 100, 100}, rgba(0, 0, 0));
  addRectangle(panels, {0, 0, 100, 50}, rgba(200, 100, 50, 128));
  const Image image = draw(panels);
  expectColour(image, 20, 70, rgba(0, 0, 0));
  expectColour(image, 20, 20, rgba(100, 50, 25), 1);  // half in encoded values, not in light
}

TEST_F(Panels, AreStretchedOverThePictureAndClipped) {
  UiFrame panels = emptyPanels(kWidth / 2, kHeight / 2);  // a screen of scale 2
  addRectangle(panels, {5, 5, 40, 40}, rgba(255, 0, 0));
  panels.commands[0].clip = {10, 8, 20, 18};
  const Image with = draw(panels), without = bare();
  EXPECT_EQ(changed(with, without, 20, 16, 40, 36), (std::array<int, 2>{400, 400}));
  panels.commands[0].clip = {30, 30, 20, 40};  // nothing
  EXPECT_EQ(draw(panels), without);
  panels.commands[0].clip = {-1e9f, -5, 1e9f, std::numeric_limits<float>::infinity()};
  EXPECT_EQ(changed(draw(panels), without, 10, 10, 80, 80)[1], 70 * 70);
}

TEST_F(Panels, FontCoverageAndPictures) {
  const uint8_t coverage[] = {0, 255};
  renderer_->setUiTexture(0, 2, 1, 1, coverage);
  const uint32_t colours[] = {rgba(255, 0, 0), rgba(0, 0, 255, 0)};
  renderer_->setUiTexture(7, 2, 1, 4, reinterpret_cast<const uint8_t*>(colours));
  UiFrame panels = emptyPanels(kWidth, kHeight);
  addRectangle(panels, {0, 0, 80, 40}, rgba(0, 0, 0));
  panels.vertices[0].u = panels.vertices[3].u = 1;  // covered all over
  addRectangle(panels, {0, 0, 80, 20}, rgba(10, 250, 20));
  addRectangle(panels, {0, 20, 80, 40}, rgba(255, 255, 255), 7);
  Image image = draw(panels);
  expectColour(image, 5, 10, rgba(0, 0, 0));
  expectColour(image, 75, 10, rgba(10, 250, 20));
  expectColour(image, 5, 30, rgba(255, 0, 0));
  expectColour(image, 75, 30, rgba(0, 0, 0));

  // The same names again: other pixels, another size, another kind.
  const uint8_t full = 255;
  renderer_->setUiTexture(0, 1, 1, 1, &full);
  const uint8_t none[] = {0, 0};
  renderer_->setUiTexture(7, 2, 1, 1, none);
  image = draw(panels);
  expectColour(image, 5, 10, rgba(10, 250, 20));
  expectColour(image, 5, 30, rgba(0, 0, 0));
}

TEST_F(Panels, AnyNumberOfCommandsBeyondSixteenBitsOfVertices) {
  UiFrame panels = emptyPanels(kWidth, kHeight);
  const auto colour = [](int x, int y) { return rgba(x, y, (x * 7 + y * 3) & 255); };
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x)
      addRectangle(panels, {float(x), float(y), float(x + 1), float(y + 1)}, colour(x, y));
  }
  ASSERT_GT(panels.vertices.size(), 65536u);
  const Image image = draw(panels);
  int wrong = 0;
  for (int y = 0; y < kHeight; ++y) {
    for (int x = 0; x < kWidth; ++x) {
      const uint32_t want = colour(x, y);
      const uint8_t* p = image.pixel(x, y);
      wrong += p[0] != (want & 255) || p[1] != (want >> 8 & 255) || p[2] != (want >> 16 & 255);
    }
  }
  EXPECT_EQ(wrong, 0);
  // Smaller and larger ones again, in both slots.
  UiFrame one = emptyPanels(kWidth, kHeight);
  addRectangle(one, {3, 3, 9, 9}, rgba(1, 2, 3));
  for (int i = 0; i < 3; ++i) {
    expectColour(draw(one), 5, 5, rgba(1, 2, 3));
    EXPECT_EQ(draw(panels), image);
  }
  EXPECT_EQ(draw(emptyPanels(0, 0)), bare());
}

TEST_F(Panels, FramesThatNameWhatIsNotThereAreRefused) {
  UiFrame good = emptyPanels(kWidth, kHeight);
  addRectangle(good, {3, 3, 9, 9}, rgba(1, 2, 3));
  const Image before = draw(good);
  const auto refused = [&](auto&& spoil) {
    UiFrame bad = good;
    spoil(bad);
    EXPECT_THROW((void)draw(bad), Error);
  };
  refused([](UiFrame& f) { f.width = 0; });
  refused([](UiFrame& f) { f.height = std::numeric_limits<float>::quiet_NaN(); });
  refused([](UiFrame& f) { f.commands[0].texture = 3; });
  refused([](UiFrame& f) { f.commands[0].indexCount = 7; });
  refused([](UiFrame& f) { f.commands[0].firstIndex = 0xffffffffu; });
  refused([](UiFrame& f) { f.indices[4] = 4; });
  refused([](UiFrame& f) { f.commands[0].firstVertex = 1; });
  const uint8_t pixels[4] = {};
  EXPECT_THROW(renderer_->setUiTexture(1, 0, 1, 1, pixels), Error);
  EXPECT_THROW(renderer_->setUiTexture(1, 1, 1, 3, pixels), Error);
  EXPECT_THROW(renderer_->setUiTexture(1, 1 << 20, 1, 1, pixels), Error);
  EXPECT_EQ(draw(good), before);
}

}  // namespace
}  // namespace argil::render
