// What X says of a pen.

#include "ui3d/studio/input/pen.h"

#include <gtest/gtest.h>

#include <array>
#include <limits>

namespace argil::studio {
namespace {

// As the drivers of tablets number them: x, y, pressure, tilts, wheel.
const PenAxes kTablet{PenAxis{2, 0, 2047}, PenAxis{3, -64, 63}, PenAxis{4, -64, 63}};

TEST(Pen, ValuatorsArePackedInTheOrderOfTheirBits) {
  const std::array<unsigned char, 1> mask{0b00011111};
  const std::array values{100.0, 200.0, 2047.0 / 4, 45.0, -30.0};
  const PenState s = decodePen(kTablet, mask, values, {});
  EXPECT_FLOAT_EQ(s.pressure, 0.25f);
  EXPECT_NEAR(s.tiltX, 0.785398, 1e-6);
  EXPECT_NEAR(s.tiltY, -0.523599, 1e-6);
}

TEST(Pen, WhatIsNotToldStaysAsItWas) {
  const PenState before{0.5f, 0.1f, -0.2f};
  const std::array<unsigned char, 1> placeOnly{0b00000011}, tiltOnly{0b00010000};
  const std::array place{1.0, 2.0};
  const std::array tilt{10.0};
  const PenState moved = decodePen(kTablet, placeOnly, place, before);
  EXPECT_EQ(moved.pressure, before.pressure);
  EXPECT_EQ(moved.tiltX, before.tiltX);
  const PenState tilted = decodePen(kTablet, tiltOnly, tilt, before);
  EXPECT_EQ(tilted.pressure, before.pressure);
  EXPECT_EQ(tilted.tiltX, before.tiltX);
  EXPECT_NEAR(tilted.tiltY, 0.174533, 1e-6);
}

TEST(Pen, ValuatorsBeyondTheFirstByteAreFound) {
  const PenAxes far{PenAxis{11, 100, 300}, {}, {}};
  const std::array<unsigned char, 2> mask{0b00000101, 0b00001000};
  const std::array values{7.0, 8.0, 200.0};
  EXPECT_FLOAT_EQ(decodePen(far, mask, values, {}).pressure, 0.5f);
}

TEST(Pen, StaysInRangeWhateverComes) {
  const std::array<unsigned char, 1> mask{0b00011100};
  for (const double value :
       {-1e9, 1e9, std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    const PenState s = decodePen(kTablet, mask, std::array{value, value, value}, {});
    EXPECT_GE(s.pressure, 0);
    EXPECT_LE(s.pressure, 1);
    EXPECT_LE(std::abs(s.tiltX), 1.5f);
  }
  // A mask that names more than came, and a range that is none.
  EXPECT_EQ(decodePen(kTablet, mask, std::array{2047.0}, {}).tiltX, 0);
  const PenAxes broken{PenAxis{2, 5, 5}, {}, {}};
  EXPECT_EQ(decodePen(broken, mask, std::array{5.0, 0.0, 0.0}, {}).pressure, 0);
}

TEST(Pen, TheEraserIsADeviceOfThatName) {
  EXPECT_TRUE(namesEraser("Wacom Intuos Pro M Pen eraser"));
  EXPECT_TRUE(namesEraser("HID 256c:006d Eraser (0)"));
  EXPECT_FALSE(namesEraser("Wacom Intuos Pro M Pen stylus"));
  EXPECT_FALSE(namesEraser(""));
}

}  // namespace
}  // namespace argil::studio
