#include "clay/import/height_image.h"

#include <gtest/gtest.h>

#include "clay/base/error.h"

namespace argil::clay {
namespace {

TEST(HeightImage, IsReadBetweenItsPixelsWithUpUp) {
  const uint16_t grey[] = {0, 65535, 65535, 65535, 0, 0};  // two rows of three
  const HeightImage image(3, 2, grey);
  // The longer side spans −1 to 1: pixels are 2/3 wide.
  EXPECT_NEAR(image.at(-0.66f, 0.34f, 0), 0.01, 1e-6);
  EXPECT_NEAR(image.at(0, 1.0f / 3, 0), 1, 1e-6);
  EXPECT_NEAR(image.at(-2.0f / 3, -1.0f / 3, 0), 1, 1e-6);
  EXPECT_NEAR(image.at(-1.0f / 3, 1.0f / 3, 0), 0.5, 1e-6);
  EXPECT_NEAR(image.at(2.0f / 3, 0, 0), 0.5, 1e-6);
  EXPECT_EQ(image.at(0, 0.7f, 0), 0);
  EXPECT_EQ(image.at(-1.01f, 0, 0), 0);
}

TEST(HeightImage, CoarserCopiesAreMeans) {
  std::vector<uint8_t> grey(16 * 16);
  for (size_t i = 0; i < grey.size(); ++i) grey[i] = (i + i / 16) % 2 ? 255 : 0;  // a chequerboard
  const HeightImage image(16, 16, grey);
  EXPECT_EQ(image.levelFor(0.5f), 0);
  EXPECT_EQ(image.levelFor(1), 0);
  EXPECT_EQ(image.levelFor(1.5f), 1);
  EXPECT_EQ(image.levelFor(3), 2);
  EXPECT_EQ(image.levelFor(1e6f), 4);
  for (int level = 1; level <= 4; ++level) EXPECT_NEAR(image.at(0.3f, -0.7f, level), 0.5, 1e-6) << level;
}

TEST(HeightImage, BadSizesAreRefused) {
  const uint8_t grey[4] = {};
  EXPECT_THROW(HeightImage(0, 4, std::span(grey, 0)), Error);
  EXPECT_THROW(HeightImage(3, 2, grey), Error);
  EXPECT_THROW(HeightImage(20000, 1, grey), Error);
}

}  // namespace
}  // namespace argil::clay
