// Hand paths of other layouts: columns by name, units, rows.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdlib>
#include <fstream>
#include <sstream>

#include "clay/base/error.h"
#include "haptics/devices/hand_path.h"

namespace argil::haptics {
namespace {

std::string sentenceOf(const std::string& text, const HandPathLayout& layout) {
  try {
    (void)HandPath::fromCsv(text, "p.csv", layout);
  } catch (const Error& e) {
    return e.what();
  }
  return "";
}

const char* kOther =
    "demo,Time_ms,x,y,z,qi,qj,qk,qw,fx,fy,fz,heat\n"
    "1,5000,0.1,0.2,0.3,0,0,0,1,1,2,3,hot\n"
    "1,5010,0.2,0.2,0.3,0,0,2,0,1,2,3,hot\n"
    "2,0,0.5,0.6,0.7,1,0,0,0,4,5,6,cold\n";

TEST(HandPathCsv, ReadsOtherLayoutsByNameAndUnits) {
  const HandPath path = HandPath::fromCsv(kOther, "p.csv", {"m", "", "demo=1"});
  ASSERT_EQ(path.points().size(), 2u);
  EXPECT_EQ(path.points()[0].timeS, 0) << "time begins at zero";
  EXPECT_NEAR(path.points()[1].timeS, 0.010, 1e-12);
  EXPECT_NEAR((path.points()[1].position - Vec3d(200, 200, 300)).norm(), 0, 1e-9) << "metres became millimetres";
  EXPECT_NEAR(path.points()[1].rotation.z(), 1, 1e-12) << "by name, and of length one";
  EXPECT_EQ(path.points()[0].forceN, Vec3d(1, 2, 3));
  const HandPath second = HandPath::fromCsv(kOther, "p.csv", {"in", "", "demo=2"});
  EXPECT_NEAR(second.points()[0].position.x(), 12.7, 1e-9);
  const HandPath named = HandPath::fromCsv("a,b,c,d,x\n0,1,2,3,99\n", "p.csv", {"mm", "t=a, x=b, y=c, z=d", ""});
  EXPECT_EQ(named.points()[0].position, Vec3d(1, 2, 3)) << "a named column wins over the usual name";
}

TEST(HandPathCsv, AByteOrderMarkIsPassedOver) {
  const std::string mark = "\xef\xbb\xbf", house = "t_s,x_mm,y_mm,z_mm\r\n0,1,2,3\r\n0.1,4,5,6\r\n";
  const HandPath plain = HandPath::fromCsv(house, "p.csv"), marked = HandPath::fromCsv(mark + house, "p.csv");
  ASSERT_EQ(marked.points().size(), 2u);
  EXPECT_EQ(marked.points()[1].position, plain.points()[1].position);
  EXPECT_EQ(HandPath::fromCsv(mark + kOther, "p.csv", {"m", "", "demo=1"}).points().size(), 2u)
      << "the first column is the one that rows are chosen by";
}

TEST(HandPathCsv, SaysWhatIsMissing) {
  EXPECT_NE(sentenceOf(kOther, {"", "", "demo=1"}).find("units"), std::string::npos);
  EXPECT_NE(sentenceOf(kOther, {"parsec", "", "demo=1"}).find("parsec"), std::string::npos);
  EXPECT_NE(sentenceOf(kOther, {"m", "", ""}).find("demo=1"), std::string::npos)
      << "time goes back where the second path begins";
  EXPECT_NE(sentenceOf(kOther, {"m", "", "demo=9"}).find("demo=9"), std::string::npos);
  EXPECT_NE(sentenceOf(kOther, {"m", "", "take=1"}).find("take"), std::string::npos);
  EXPECT_NE(sentenceOf(kOther, {"m", "x=tip", ""}).find("tip"), std::string::npos);
  EXPECT_NE(sentenceOf(kOther, {"m", "speed=x", ""}).find("speed"), std::string::npos);
  EXPECT_NE(sentenceOf(kOther, {"m", "x", ""}).find("name=value"), std::string::npos);
  EXPECT_NE(sentenceOf("t,x,y\n0,0,0\n", {"m", "", ""}).find("z=NAME"), std::string::npos);
  EXPECT_NE(sentenceOf("t,time,x,y,z\n0,0,0,0,0\n", {"m", "", ""}).find("two columns"), std::string::npos);
  EXPECT_NE(sentenceOf("t,x,y,z,qw\n0,0,0,0,1\n", {"m", "", ""}).find("qx"), std::string::npos);
  EXPECT_NE(sentenceOf("t,x,y,z\n0,0,0,1e306\n", {"m", "", ""}).find("line 2"), std::string::npos)
      << "overflows when scaled";
}

TEST(HandPathCsv, ReadsARecordedPathOfAnotherLaboratory) {
  const char* data = std::getenv("ARGIL_DATA");
  if (!data) GTEST_SKIP() << "ARGIL_DATA is not set";
  std::ifstream in(std::string(data) + "/haptic/wiping_rim_6demos.csv");
  std::ostringstream text;
  text << in.rdbuf();
  size_t points = 0;
  for (int demo = 1; demo <= 6; ++demo) {
    const HandPath path = HandPath::fromCsv(text.str(), "wiping", {"m", "", "demo=" + std::to_string(demo)});
    points += path.points().size();
    EXPECT_GT(path.durationS(), 5);
    EXPECT_LT(path.points()[0].position.norm(), 2000) << "an arm's length in mm";
    EXPECT_GT(path.points()[0].position.norm(), 100);
  }
  EXPECT_EQ(points, 10920u);
}

TEST(HandPathCsv, WhatTheFileSaysIsQuotedInOneLine) {
  for (const std::string& text : {std::string("t_s,x_mm,y_mm,z\r\x1b[31mmm\n"),
                                  "t_s,x_mm,y_mm,z_mm\n0,1,2,\r3\x07" + std::string(500, '9') + "\n"}) {
    try {
      (void)HandPath::fromCsv(text, "p.csv");
      FAIL() << text;
    } catch (const Error& error) {
      const std::string sentence = error.what();
      EXPECT_TRUE(std::all_of(sentence.begin(), sentence.end(), [](unsigned char c) { return c >= ' '; })) << sentence;
      EXPECT_LT(sentence.size(), 250u) << sentence;
    }
  }
}

}  // namespace
}  // namespace argil::haptics
