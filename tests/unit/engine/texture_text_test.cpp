// Textures in words.

#include "engine/text/texture_text.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "clay/base/error.h"

namespace argil::engine {
namespace {

using testing::HasSubstr;

std::string refusal(const std::string& text) {
  try {
    (void)parseTexture(text);
    return "";
  } catch (const Error& error) {
    return error.what();
  }
}

TEST(TextureText, EachKindHasItsNumbers) {
  EXPECT_EQ(parseTexture("ridges:2:0.1")->rangeMm(), 0.2);
  EXPECT_EQ(parseTexture("ridges:2:0.1")->finestMm(), 2);
  EXPECT_EQ(parseTexture("bumps:3:0.2")->finestMm(), 3);
  EXPECT_EQ(4 * parseTexture("grain:4:0.2:3")->finestMm(), parseTexture("grain:4:0.2:1")->finestMm())
      << "half as long each octave";
  // Flat where the surface faces along what lies across the ridges.
  const auto along = parseTexture("ridges:2:0.1:0,1,0");
  EXPECT_NE(along->height({0, 0.3, 0}, {0, 0, 1}, 0, nullptr), along->height({0, 0.9, 0}, {0, 0, 1}, 0, nullptr));
  EXPECT_EQ(along->height({0.3, 0, 0}, {0, 0, 1}, 0, nullptr), along->height({0.9, 0, 0}, {0, 0, 1}, 0, nullptr));
}

// Four columns and 64 rows, darker from row to row: across it nothing changes, along it everything.
TEST(TextureText, AnImageKeepsItsRowsAndColumnsWhateverItsNameHolds) {
  const auto folder = std::filesystem::temp_directory_path() / ("argil-texture-" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
  const std::string file = (folder / "a:b:c.pgm").string();
  {
    std::ofstream out(file, std::ios::binary);
    out << "P5\n4 64\n255\n";
    for (int row = 0; row < 64; ++row)
      for (int column = 0; column < 4; ++column) out.put(static_cast<char>(255 - 4 * row));
  }
  const auto texture = parseTexture("image:" + file + ":0.5:0.25");
  EXPECT_EQ(texture->rangeMm(), 0.5);
  const auto at = [&](double x, double y) { return texture->height({x, y, 0}, {0, 0, 1}, 0, nullptr); };
  EXPECT_NEAR(at(0.3, 10), at(1.1, 10), 1e-6);
  EXPECT_GT(std::abs(at(1, 4) - at(1, 28)), 0.3) << "three quarters of its rows apart";
  EXPECT_THAT(refusal("image:" + (folder / "none.pgm").string() + ":1:1"), HasSubstr("none.pgm"));
  EXPECT_THAT(refusal("image:" + file + ":0:1"), HasSubstr("--texture"));
  std::filesystem::remove_all(folder);
}

TEST(TextureText, WhatIsNoneIsRefusedInASentence) {
  for (const char* text : {"", "velvet", "ridges", "ridges:1", "ridges:1:x", "ridges:1:0.1:0,1", "bumps:1:0.1:3",
                           "grain:1:0.1:1.5", "grain:1:0.1:1e9", "image:a.png:1", "ridges:inf:1"})
    EXPECT_THAT(refusal(text), HasSubstr("--texture")) << text;
}

}  // namespace
}  // namespace argil::engine
