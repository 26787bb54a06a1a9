// Records: written, read back, found among other bytes, refused when anything in them has changed.

#include "io/records/record.h"

#include <gtest/gtest.h>

#include <random>

namespace argil::io {
namespace {

std::vector<std::byte> someBytes(size_t count, uint32_t seed) {
  std::mt19937 random(seed);
  std::vector<std::byte> bytes(count);
  for (std::byte& each : bytes) each = static_cast<std::byte>(random());
  return bytes;
}

TEST(Record, ComesBackAsItWas) {
  for (const size_t size : {size_t{0}, size_t{1}, size_t{100}, kMostRecordBody}) {
    std::vector<std::byte> bytes;
    const auto body = someBytes(size, 7);
    appendRecord(bytes, {RecordKind::brick, RecordCodec::zstd, 0, 5, 1ull << 40}, body);
    const auto view = parseRecord(bytes);
    ASSERT_TRUE(view);
    EXPECT_EQ(view->header.kind, RecordKind::brick);
    EXPECT_EQ(view->header.codec, RecordCodec::zstd);
    EXPECT_EQ(view->header.owner, 5u);
    EXPECT_EQ(view->header.id, 1ull << 40);
    EXPECT_TRUE(std::equal(body.begin(), body.end(), view->body.begin(), view->body.end()));
    EXPECT_EQ(view->whole.size(), bytes.size());
  }
}

TEST(Record, AnyFlippedBitIsNoticed) {
  std::vector<std::byte> bytes;
  appendRecord(bytes, {RecordKind::node, RecordCodec::raw, 0, 1, 9}, someBytes(60, 3));
  for (size_t bit = 0; bit < bytes.size() * 8; ++bit) {
    bytes[bit / 8] ^= std::byte(1u << (bit % 8));
    EXPECT_FALSE(parseRecord(bytes)) << "bit " << bit;
    bytes[bit / 8] ^= std::byte(1u << (bit % 8));
  }
  for (size_t size = 0; size < bytes.size(); ++size) EXPECT_FALSE(parseRecord(std::span(bytes).first(size)));
}

TEST(Record, IsFoundAmongOtherBytes) {
  std::vector<std::byte> bytes = someBytes(1000, 1);
  std::vector<size_t> begins;
  for (uint64_t id = 1; id <= 20; ++id) {
    begins.push_back(bytes.size());
    appendRecord(bytes, {RecordKind::chunk, RecordCodec::raw, 0, 0, id}, someBytes(37 * id, static_cast<uint32_t>(id)));
    const auto noise = someBytes(id % 3 == 0 ? 0 : 11 * id, 99);
    bytes.insert(bytes.end(), noise.begin(), noise.end());
  }
  bytes[begins[4] + 50] ^= std::byte{1};  // the fifth is damaged
  std::vector<uint64_t> found;
  for (size_t at = findRecord(bytes, 0); at < bytes.size();) {
    const auto view = parseRecord(std::span(bytes).subspan(at));
    ASSERT_TRUE(view);
    EXPECT_EQ(at, begins[view->header.id - 1]);
    found.push_back(view->header.id);
    at = findRecord(bytes, at + view->whole.size());
  }
  EXPECT_EQ(found.size(), 19u);
}

}  // namespace
}  // namespace argil::io
