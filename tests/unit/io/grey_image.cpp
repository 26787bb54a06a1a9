// Pictures as grey levels.

#include "io/grey_image.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>

#include "clay/error.h"

namespace argil::io {
namespace {

namespace fs = std::filesystem;

class GreyImageFile : public testing::Test {
 protected:
  void SetUp() override { fs::create_directories(folder_); }
  void TearDown() override { fs::remove_all(folder_); }
  fs::path write(const std::string& bytes) {
    std::ofstream(folder_ / "a.pgm", std::ios::binary) << bytes;
    return folder_ / "a.pgm";
  }
  const fs::path folder_ = fs::temp_directory_path() / ("argil-grey-" + std::to_string(::getpid()));
};

TEST_F(GreyImageFile, levelsRowByRow) {
  const GreyImage image = readGreyImage(write("P5\n3 2\n255\n" + std::string("\x00\x33\x66\x99\xcc\xff", 6)), 16);
  ASSERT_EQ(image.width, 3);
  ASSERT_EQ(image.height, 2);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(image.grey[size_t(i)], 0.2f * float(i), 1e-5f);
}

TEST_F(GreyImageFile, whatIsNoneIsRefused) {
  const std::string whole = "P5\n3 2\n255\n" + std::string("\x00\x33\x66\x99\xcc\xff", 6);
  for (size_t cut = 1; cut < 6; ++cut) EXPECT_THROW((void)readGreyImage(write(whole.substr(0, cut)), 16), Error) << cut;
  EXPECT_THROW((void)readGreyImage(write(whole), 2), Error);
  EXPECT_THROW((void)readGreyImage(folder_ / "missing.png", 16), Error);
  EXPECT_THROW((void)readGreyImage(folder_, 16), Error);
}

TEST_F(GreyImageFile, whatIsWrongIsOneLineWhateverTheFileSays) {
  // A chunk that nobody knows, whose name holds a line end: libraries quote it.
  const std::string header = std::string("\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\0\1\0\0\0\1\x08\0\0\0\0", 8 + 8 + 13) + "crc!";
  const std::string image = header + std::string("\0\0\0\0", 4) + "A\nCD" + "crc!";
  try {
    (void)readGreyImage(write(image), 16);
    FAIL();
  } catch (const Error& error) {
    EXPECT_EQ(std::string(error.what()).find_first_of("\r\n"), std::string::npos) << error.what();
    EXPECT_NE(std::string(error.what()).find("damaged"), std::string::npos) << error.what();
  }
}

}  // namespace
}  // namespace argil::io
