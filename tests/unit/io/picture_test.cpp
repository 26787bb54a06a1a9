// Pictures as grey levels and in colour, taken apart by the reader process.

#include "io/models/picture.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include "io/models/reader_process.h"
#include "tests/support/mesh_samples.h"

namespace argil::io {
namespace {

using samples::bytesOf;
using samples::errorOf;
using testing::ElementsAre;
using testing::HasSubstr;

class PictureFile : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& bytes) {
    samples::spill(folder_ / "a.pgm", bytes);
    return folder_ / "a.pgm";
  }
  // A reader that is a shell script, until the test ends.
  void replaceReader(const std::string& line) {
    const auto path = folder_ / "reader";
    samples::spill(path, "#!/bin/sh\n" + line + "\n");
    ::chmod(path.c_str(), 0755);
    ::setenv("ARGIL_READER", path.c_str(), 1);
  }
  void TearDown() override { ::unsetenv("ARGIL_READER"); }

  const samples::Folder folder_;
  const std::string levels_ = "P5\n3 2\n255\n" + std::string("\x00\x33\x66\x99\xcc\xff", 6);
};

TEST_F(PictureFile, LevelsRowByRow) {
  const GreyImage image = readGreyImage(write(levels_), 16);
  ASSERT_EQ(image.width, 3);
  ASSERT_EQ(image.height, 2);
  for (int i = 0; i < 6; ++i) EXPECT_NEAR(image.grey[size_t(i)], 0.2f * float(i), 1e-5f);
}

// PGM has the high byte first, whatever the machine.
TEST_F(PictureFile, LevelsOfSixteenBits) {
  const GreyImage image = readGreyImage(write("P5\n3 1\n65535\n" + std::string("\x01\0\x80\0\xff\xfe", 6)), 16);
  EXPECT_EQ(image.grey, (std::vector<float>{256 / 65535.0f, 32768 / 65535.0f, 65534 / 65535.0f}));
}

TEST_F(PictureFile, WhatIsNoneIsRefused) {
  for (size_t cut = 1; cut < 6; ++cut)
    EXPECT_THROW((void)readGreyImage(write(levels_.substr(0, cut)), 16), Error) << cut;
  EXPECT_THAT(errorOf([&] { (void)readGreyImage(write(levels_), 2); }), HasSubstr("3 by 2 pixels, at most 2"));
  EXPECT_THAT(errorOf([&] { (void)readGreyImage(folder_ / "missing.png", 16); }), HasSubstr("there is no such file"));
  EXPECT_THAT(errorOf([&] { (void)readGreyImage(folder_.path(), 16); }), HasSubstr("is a folder"));
  EXPECT_THAT(errorOf([&] { (void)readGreyImage(write(""), 16); }), HasSubstr("is empty"));
}

TEST_F(PictureFile, WhatIsWrongIsOneLineWhateverTheFileSays) {
  // A chunk that nobody knows, whose name holds a line end: libraries quote it.
  const std::string header =
      std::string("\x89PNG\r\n\x1a\n\0\0\0\x0dIHDR\0\0\0\1\0\0\0\1\x08\0\0\0\0", 8 + 8 + 13) + "crc!";
  const std::string image = header + std::string("\0\0\0\0", 4) + "A\nCD" + "crc!";
  EXPECT_THAT(errorOf([&] { (void)readGreyImage(write(image), 16); }), HasSubstr("damaged"));
}

TEST_F(PictureFile, ColourOutOfBytes) {
  const std::string ppm = "P6\n1 2\n255\n" + std::string("\x10\x20\x30\xff\x00\x80", 6);
  const ColourImage image = unpackPicture(bytesOf(ppm), 16);
  EXPECT_EQ(image.width, 1);
  EXPECT_EQ(image.height, 2);
  EXPECT_THAT(image.rgba, ElementsAre(0x10, 0x20, 0x30, 0xff, 0xff, 0x00, 0x80, 0xff));
  // Sixteen bits, and grey.
  const std::string deep = "P6\n1 2\n65535\n" + std::string("\x10\0\x20\0\x30\0\xff\0\0\0\x80\0", 12);
  EXPECT_THAT(unpackPicture(bytesOf(deep), 16).rgba, ElementsAre(0x10, 0x20, 0x30, 0xff, 0xff, 0x00, 0x80, 0xff));
  EXPECT_THAT(unpackPicture(bytesOf("P5\n1 1\n255\nA"), 16).rgba, ElementsAre('A', 'A', 'A', 0xff));
  EXPECT_THAT(errorOf([&] { (void)unpackPicture(bytesOf(ppm), 1); }), HasSubstr("the picture: 1 by 2 pixels"));
  EXPECT_THAT(errorOf([&] { (void)unpackPicture({}, 16); }), HasSubstr("the picture: is empty"));
}

// No picture of somebody else is looked at in this process: what crashes the library that does is a sentence.
TEST_F(PictureFile, IsParsedByTheReaderAlone) {
  const auto file = write(levels_);
  replaceReader("kill -SEGV $$");
  EXPECT_THAT(errorOf([&] { (void)readGreyImage(file, 16); }), HasSubstr("a.pgm: made the reader crash"));
  EXPECT_THAT(errorOf([&] { (void)unpackPicture(bytesOf(levels_), 16); }),
              HasSubstr("the picture: made the reader crash"));
}

TEST_F(PictureFile, WhatTheReaderSendsIsNotBelieved) {
  const auto file = write(levels_);
  const auto message = [](wire::Kind kind, const std::string& payload) {
    std::string bytes;
    samples::append(bytes, wire::Head{kind, uint32_t(payload.size())});
    return bytes + payload;
  };
  const auto size = [&](uint32_t width, uint32_t height) {
    std::string payload;
    samples::append(payload, wire::Picture{width, height});
    return message(wire::Kind::picture, payload);
  };
  const auto row = [&](std::initializer_list<float> values) {
    std::string payload;
    for (const float value : values) samples::append(payload, value);
    return message(wire::Kind::levels, payload);
  };
  const std::string end = message(wire::Kind::end, "");
  const auto outcome = [&](const std::string& spoken) {
    const SpokenReader reader(bytesOf(spoken));
    return errorOf([&] { (void)readGreyImage(file, 16); });
  };
  {
    const std::string good = size(2, 1) + row({0, 1}) + end;
    const SpokenReader reader(bytesOf(good));
    EXPECT_THAT(readGreyImage(file, 16).grey, ElementsAre(0, 1));
  }
  for (const std::string& lie :
       {size(2, 1) + row({0}) + end, size(2, 1) + row({0, 1, 1}) + end, row({0}) + end, size(17, 1) + row({0}) + end,
        size(0, 0) + end, size(1, 1) + size(1, 1) + row({0}) + end, size(1, 1) + row({2}) + end,
        size(1, 1) + row({NAN}) + end, size(1, 1) + row({0}), end,
        size(1, 1) + message(wire::Kind::pixels, "abcd") + end})
    EXPECT_THAT(outcome(lie), HasSubstr("a.pgm: could not be read, as the reader sent what it should not"));
}

}  // namespace
}  // namespace argil::io
