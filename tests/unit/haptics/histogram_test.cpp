#include "haptics/base/histogram.h"

#include <gtest/gtest.h>

namespace argil::haptics {
namespace {

TEST(Histogram, GivesQuantilesWithinThreePerCent) {
  Histogram h;
  for (int64_t i = 1; i <= 100'000; ++i) h.add(i * 10);
  EXPECT_EQ(h.count(), 100'000u);
  EXPECT_NEAR(h.quantileUs(0.5), 500, 500 * 0.035);
  EXPECT_NEAR(h.quantileUs(0.99), 990, 990 * 0.035);
  EXPECT_GE(h.quantileUs(0.999), 999);
  EXPECT_DOUBLE_EQ(h.maxUs(), 1000);
  h.add(-5);
  h.add(int64_t{1} << 60);
  EXPECT_EQ(h.count(), 100'002u);
  Histogram small;
  for (int64_t i = 0; i < 32; ++i) small.add(i);
  EXPECT_DOUBLE_EQ(small.quantileUs(0.5), 0.016);
  EXPECT_DOUBLE_EQ(Histogram().quantileUs(0.5), 0);
}

}  // namespace
}  // namespace argil::haptics
