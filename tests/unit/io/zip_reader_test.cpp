#include "io/bytes/zip_reader.h"

#include <gtest/gtest.h>

#include "io/bytes/unpack_limit.h"
#include "tests/support/package_samples.h"

namespace argil::io {
namespace {

using samples::bytesOf;
using samples::errorOf;
using samples::zip;

std::string content(const std::string& archive, const std::string& name) {
  const Input input{bytesOf(archive), "a.zip"};
  ZipReader reader(input);
  const ZipReader::Part* part = reader.find(name);
  if (part == nullptr) return "(none)";
  const FileBytes bytes = reader.read(*part);
  return {reinterpret_cast<const char*>(bytes.data.get()), bytes.size};
}

void expectRefused(const std::string& archive, const std::string& name, const char* because) {
  const std::string error = errorOf([&] { (void)content(archive, name); });
  EXPECT_EQ(error.find("a.zip: "), 0u) << error;
  EXPECT_NE(error.find(because), std::string::npos) << error;
}

/// `archive` with `value` in place of the bytes at `at`.
template <class T>
std::string with(std::string archive, size_t at, T value) {
  std::memcpy(archive.data() + at, &value, sizeof value);
  return archive;
}

TEST(ZipReader, ReadsStoredAndDeflatedParts) {
  const std::string archive = zip({{"a.txt", "hello"}, {"b/c.bin", std::string("\0\1\2", 3), true}, {"empty", ""}});
  EXPECT_EQ(content(archive, "a.txt"), "hello");
  EXPECT_EQ(content(archive, "b/c.bin"), std::string("\0\1\2", 3));
  EXPECT_EQ(content(archive, "B/C.BIN"), std::string("\0\1\2", 3));
  EXPECT_EQ(content(archive, "empty"), "");
  EXPECT_EQ(content(archive, "a"), "(none)");
}

TEST(ZipReader, ReadsNumbersOfSixtyFourBits) {
  EXPECT_EQ(content(zip({{"x", "1"}, {"a.txt", "hello", true}}, true), "a.txt"), "hello");
}

TEST(ZipReader, ACommentAtTheEndIsPassedOver) {
  std::string archive = zip({{"a.txt", "hello"}});
  archive[archive.size() - 2] = 7;
  EXPECT_EQ(content(archive + "comment", "a.txt"), "hello");
  expectRefused(archive + "comment!", "a.txt", "has no end");
}

TEST(ZipReader, NamesThatLeadElsewhereAreRefused) {
  for (const char* name : {"../a.txt", "/a.txt", "a/../../b", "..\\a", "./a", ""})
    expectRefused(zip({{name, "1"}}), "a.txt", "holds a part named");
  EXPECT_EQ(content(zip({{"a\\b..txt", "1"}}), "a/b..txt"), "1");
}

TEST(ZipReader, TwoPartsOfOneNameAreRefused) {
  expectRefused(zip({{"a.txt", "1"}, {"A.TXT", "2"}}), "a.txt", "two parts");
}

TEST(ZipReader, EveryCutIsNoticed) {
  for (const bool wide : {false, true}) {
    const std::string archive = zip({{"a.txt", "hello"}, {"b", "world", true}}, wide);
    for (size_t length = 0; length < archive.size(); ++length) expectRefused(archive.substr(0, length), "b", "cut off");
  }
}

// Offsets: the local header of "a" has 31 bytes, then its data, then the table (46 + 1 bytes), then the end.
TEST(ZipReader, WhatLiesIsRefused) {
  const std::string stored = zip({{"a", "hello"}}), packed = zip({{"a", "hello", true}});
  expectRefused(with(stored, 31, 'j'), "a", "checksum");
  expectRefused(with(packed, 31, '\x07'), "a", "cannot be unpacked");
  const size_t table = 31 + 5, packedTable = 31 + 10;
  ASSERT_EQ(content(with(stored, table, uint32_t(0x02014b50)), "a"), "hello");
  expectRefused(with(stored, table + 24, uint32_t(6)), "a", "cannot have as many");
  expectRefused(with(packed, packedTable + 24, uint32_t(6)), "a", "cannot be unpacked");
  expectRefused(with(packed, packedTable + 24, uint32_t(4)), "a", "cannot be unpacked");
  expectRefused(with(packed, packedTable + 20, uint32_t(9)), "a", "cannot be unpacked");
  expectRefused(with(packed, packedTable + 24, uint32_t(16'000'000)), "a", "cannot have as many");
  expectRefused(with(stored, table + 20, uint32_t(500)), "a", "beyond the end");
  expectRefused(with(stored, table + 42, uint32_t(3)), "a", "not where it should be");
  expectRefused(with(stored, table + 42, uint32_t(0xfffffff0)), "a", "not where it should be");
  expectRefused(with(stored, table + 8, uint16_t(1)), "a", "encrypted");
  expectRefused(with(stored, table + 10, uint16_t(14)), "a", "method 14");
  expectRefused(with(stored, 30, 'b'), "a", "contradicts");
  expectRefused(with(stored, 8, uint16_t(8)), "a", "contradicts");
  const size_t end = stored.size() - 22;
  expectRefused(with(stored, end + 8, uint16_t(2)), "a", "volumes");
  expectRefused(with(with(stored, end + 8, uint16_t(2)), end + 10, uint16_t(2)), "a", "shorter than it says");
  expectRefused(with(stored, end + 16, uint32_t(end)), "a", "lies outside");
}

TEST(ZipReader, BombsAreRefusedBeforeTheyAreUnpacked) {
  const std::string archive = zip({{"a", std::string(65535, 'x'), true}, {"b", ""}});
  std::string bomb = archive;
  const size_t table = bomb.find("PK\x01\x02");
  bomb = with(bomb, table + 24, uint32_t(16'700'000));
  expectRefused(bomb, "a", "cannot be unpacked");
  bomb = with(bomb, table + 24, uint32_t(17'000'000));
  expectRefused(bomb, "a", "more than 50 times its size");
  // One that hides among others.
  bomb = zip({{"a", std::string(65535, 'x'), true}, {"b", std::string(400'000, 'b')}});
  bomb = with(bomb, bomb.find("PK\x01\x02") + 24, uint32_t(20'000'000));
  expectRefused(bomb, "a", "more than is read");
}

// Each part is small enough by itself: what counts is the sum of all that was unpacked.
TEST(ZipReader, PartsThatAreTooMuchTogetherAreRefused) {
  constexpr uint32_t kSize = 64 << 20;
  constexpr int kFit = 2 * int(kMostUnpacked / kSize);
  // No deflate begins like this, so that none is unpacked in earnest: the place for it is taken and given back.
  std::string archive = zip({{"a", std::string(kSize / kMostUnpackRatio + 1, '\xff')}});
  const size_t table = archive.find("PK\x01\x02");
  archive = with(with(archive, 8, uint16_t(8)), table + 10, uint16_t(8));
  archive = with(archive, table + 24, kSize);
  const Input input{bytesOf(archive), "a.zip"};
  ZipReader reader(input);
  const ZipReader::Part& part = reader.parts().at(0);
  for (int i = 0; i < kFit; ++i) {
    const std::string error = errorOf([&] { (void)reader.read(part); });
    ASSERT_NE(error.find("cannot be unpacked"), std::string::npos) << i << ": " << error;
  }
  const std::string error = errorOf([&] { (void)reader.read(part); });
  EXPECT_NE(error.find("more than is read"), std::string::npos) << error;
}

}  // namespace
}  // namespace argil::io
