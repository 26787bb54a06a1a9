#include "render/view/image.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "clay/base/error.h"

namespace argil::render {
namespace {

namespace fs = std::filesystem;

class PngFile : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = fs::temp_directory_path() / ("argil_png_" + std::to_string(::getpid()));
    fs::create_directories(folder_);
    image_.width = 3;
    image_.height = 2;
    image_.rgba.assign(24, 200);
  }
  void TearDown() override { fs::remove_all(folder_); }
  size_t files() const { return size_t(std::distance(fs::directory_iterator(folder_), fs::directory_iterator())); }

  fs::path folder_;
  Image image_;
};

TEST_F(PngFile, IsAPngOfThatSize) {
  const auto bytes = encodePng(image_);
  const uint8_t signature[] = {0x89, 'P', 'N', 'G', 13, 10, 26, 10};
  ASSERT_GT(bytes.size(), 33u);
  EXPECT_TRUE(std::equal(std::begin(signature), std::end(signature), bytes.begin()));
  EXPECT_EQ(bytes[19], 3);
  EXPECT_EQ(bytes[23], 2);
  EXPECT_EQ(bytes[24], 8);  // bits a channel
  EXPECT_EQ(bytes[25], 6);  // RGBA
}

TEST_F(PngFile, ReplacesTheOldFileAndLeavesNothingElse) {
  const fs::path path = folder_ / "a.png";
  std::ofstream(path) << "old";
  writePng(image_, path.string());
  EXPECT_EQ(fs::file_size(path), encodePng(image_).size());
  EXPECT_EQ(files(), 1u);
}

TEST_F(PngFile, FailureNamesThePathAndLeavesNothing) {
  const std::string missing = (folder_ / "missing" / "a.png").string();
  try {
    writePng(image_, missing);
    FAIL() << "no error";
  } catch (const Error& error) {
    EXPECT_NE(std::string(error.what()).find(missing), std::string::npos);
  }
  fs::create_directory(folder_ / "taken.png");
  EXPECT_THROW(writePng(image_, (folder_ / "taken.png").string()), Error);
  EXPECT_EQ(files(), 1u);
}

TEST_F(PngFile, ImageWithoutPixelsIsRefused) {
  EXPECT_THROW(writePng({}, (folder_ / "a.png").string()), Error);
  EXPECT_EQ(files(), 0u);
}

}  // namespace
}  // namespace argil::render
