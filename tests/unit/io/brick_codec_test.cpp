// Bricks: packed and unpacked to the bit; what no version can hold is refused.

#include "io/records/brick_codec.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>
#include <random>

#include "clay/field/primitives.h"
#include "clay/store/store.h"

namespace argil::io {
namespace {

using clay::Brick;
using clay::FloatBrick;
using clay::kBrickVoxels;

FloatBrick brickOf(float value) {
  FloatBrick brick;
  std::fill(std::begin(brick.value), std::end(brick.value), value);
  brick.coord = {-7, 13999, 4};
  return brick;
}

struct Packed {
  RecordCodec codec;
  std::vector<std::byte> body;
};

Packed pack(const FloatBrick& brick, float band, RecordCodec codec) {
  BrickCodec packer;
  const auto body = packer.pack(brick, band, codec);
  return {codec, {body.begin(), body.end()}};
}

std::optional<Coord> unpack(const Packed& packed, float band, FloatBrick& brick, RecordKind kind = RecordKind::brick) {
  RecordView record;
  record.header = {kind, packed.codec, static_cast<uint16_t>(packed.body.size()), 1, 1};
  record.body = packed.body;
  BrickCodec unpacker;
  return unpacker.unpack(record, band, brick);
}

void expectComesBack(const FloatBrick& brick, float band) {
  for (const RecordCodec codec : {RecordCodec::raw, RecordCodec::predicted}) {
    const Packed packed = pack(brick, band, codec);
    ASSERT_LE(packed.body.size(), kMostRecordBody);
    FloatBrick back;
    ASSERT_EQ(unpack(packed, band, back), brick.coord);
    ASSERT_EQ(std::memcmp(back.value, brick.value, sizeof brick.value), 0);
    for (int i = 0; i < kBrickVoxels; ++i) ASSERT_EQ(back.inside[i / 64] >> (i % 64) & 1, uint64_t{brick.value[i] < 0});
  }
}

TEST(BrickCodec, ClayComesBackToTheBit) {
  for (const float band : {2.0f, 3.0f, 8.0f}) {
    clay::Grid grid;
    grid.voxelMm = 1;
    grid.band = band;
    const auto version = clay::makeSphere(clay::Store::make(), grid, Vec3d(0.3, 0.2, 0.1), 30);
    size_t bytes = 0, bricks = 0;
    version.forEachBrick([&](const Brick& each) {
      const auto& brick = static_cast<const FloatBrick&>(each);
      ASSERT_NO_FATAL_FAILURE(expectComesBack(brick, band));
      bytes += pack(brick, band, RecordCodec::predicted).body.size();
      ++bricks;
    });
    EXPECT_LT(bytes, bricks * 1000) << band;
  }
}

TEST(BrickCodec, AnyDistancesComeBack) {
  std::mt19937 random(20261120);
  const float band = 3;
  for (int round = 0; round < 400; ++round) {
    FloatBrick brick = brickOf(0);
    const int kind = round % 8;
    for (float& phi : brick.value) {
      float value = std::uniform_real_distribution<float>(-4, 4)(random);
      // every order of magnitude, denormals too
      if (kind == 1) value = std::bit_cast<float>(static_cast<uint32_t>(random()));
      if (kind == 2 && random() % 40 != 0) value = band;
      if (kind == 3 && random() % 40 != 0) value = -band;
      if (kind == 4) value = random() % 2 ? band : -band;
      if (kind == 5) value = 0;
      if (kind == 6) value = std::nextafter(band, random() % 2 ? 0.0f : 9.0f);
      if (!std::isfinite(value)) value = 1e-42f;
      phi = std::clamp(value, -band, band) + 0.0f;
    }
    brick.value[random() % kBrickVoxels] = 0.25f;
    ASSERT_NO_FATAL_FAILURE(expectComesBack(brick, band)) << "round " << round;
  }
}

TEST(BrickCodec, WhatPackingCannotShortenStaysRaw) {
  std::mt19937 random(3);
  FloatBrick brick = brickOf(0);
  for (float& phi : brick.value)
    phi = std::ldexp(random() % 2 ? 1.0f : -1.0f, -static_cast<int>(random() % 120)) *
          (1 + static_cast<float>(random() % 65536) / 65536);
  const Packed packed = pack(brick, 3, RecordCodec::predicted);
  EXPECT_EQ(packed.codec, RecordCodec::raw);
  ASSERT_NO_FATAL_FAILURE(expectComesBack(brick, 3));
}

// Codes of every kind of brick, as recorded at either codec.
TEST(BrickCodec, SixteenBitsComeBackToTheBit) {
  std::mt19937 random(20261120);
  for (int kind = 0; kind < 6; ++kind)
    for (int round = 0; round < 200; ++round) {
      clay::FixedBrick brick, back;
      brick.coord = {-7, 13999, 4};
      brick.step = back.step = clay::stepOf(clay::Precision::fixed16, 3);
      const double slope[3] = {0.6, -0.5, 0.3 * kind}, shift = double(random() % 1000) / 100 - 5;
      for (int i = 0; i < kBrickVoxels; ++i) {
        double code = (slope[0] * (i >> 6) + slope[1] * (i >> 3 & 7) + slope[2] * (i & 7) + shift) / double(brick.step);
        if (kind == 4) code = double(random() % 65535) - clay::kMostCode;
        if (kind == 5 && random() % 40 != 0) code = clay::kMostCode;
        brick.code[i] = static_cast<int16_t>(std::clamp(code, -double(clay::kMostCode), double(clay::kMostCode)));
      }
      brick.code[random() % kBrickVoxels] = 7;
      for (const RecordCodec wanted : {RecordCodec::raw, RecordCodec::predicted}) {
        BrickCodec codec;
        RecordCodec used = wanted;
        const auto body = codec.pack(brick, 3, used);
        EXPECT_TRUE(used == RecordCodec::raw16 || used == RecordCodec::predicted16);
        if (kind < 4 && wanted == RecordCodec::predicted) {
          EXPECT_LT(body.size(), 700u);
        }
        RecordView record;
        const std::vector<std::byte> copy(body.begin(), body.end());
        record.header = {RecordKind::brick, used, static_cast<uint16_t>(copy.size()), 1, 1};
        record.body = copy;
        ASSERT_EQ(codec.unpack(record, 3, back), brick.coord);
        ASSERT_EQ(std::memcmp(back.code, brick.code, sizeof brick.code), 0);
        for (int i = 0; i < kBrickVoxels; ++i)
          ASSERT_EQ(back.inside[i / 64] >> (i % 64) & 1, uint64_t{brick.code[i] < 0});
        FloatBrick other;
        EXPECT_FALSE(codec.unpack(record, 3, other)) << "another form";
        record.body = std::span(copy).first(copy.size() - 1);
        EXPECT_FALSE(codec.unpack(record, 3, back)) << "shorter";
      }
    }
}

TEST(BrickCodec, SixteenBitsRefuseWhatNoVersionHolds) {
  clay::FixedBrick brick, back;
  brick.coord = {1, 2, 3};
  brick.step = back.step = clay::stepOf(clay::Precision::fixed16, 3);
  std::mt19937 random(20261120);
  int read = 0;
  for (int round = 0; round < 20000; ++round) {
    std::fill(std::begin(brick.code), std::end(brick.code), static_cast<int16_t>(clay::kMostCode));
    if (round > 0) brick.code[random() % kBrickVoxels] = static_cast<int16_t>(random() % 65535 - clay::kMostCode);
    if (round % 3 == 1) brick.code[3] = INT16_MIN;
    BrickCodec codec;
    RecordCodec used = RecordCodec(round % 2 * 2);
    const auto body = codec.pack(brick, 3, used);
    std::vector<std::byte> bytes(body.begin(), body.end());
    if (round % 3 == 2 && round > 100)
      for (int i = 0; i < 3; ++i) bytes[random() % bytes.size()] ^= static_cast<std::byte>(1u << random() % 8);
    RecordView record;
    record.header = {RecordKind::brick, used, static_cast<uint16_t>(bytes.size()), 1, 1};
    record.body = bytes;
    const bool sound = codec.unpack(record, 3, back).has_value();
    if (round == 0) {
      EXPECT_FALSE(sound) << "no voxel in the band";
    }
    if (round % 3 == 1) {
      EXPECT_FALSE(sound) << "beyond the band";
    }
    if (!sound) continue;
    ++read;
    EXPECT_TRUE(
        std::all_of(std::begin(back.code), std::end(back.code), [](int code) { return code >= -clay::kMostCode; }));
    EXPECT_TRUE(std::any_of(std::begin(back.code), std::end(back.code),
                            [](int code) { return std::abs(code) < clay::kMostCode; }));
  }
  EXPECT_GT(read, 1000);
}

TEST(BrickCodec, RefusesWhatNoVersionHolds) {
  const float band = 3;
  FloatBrick sound = brickOf(band), back;
  sound.value[100] = 1;
  ASSERT_TRUE(unpack(pack(sound, band, RecordCodec::raw), band, back));
  for (const RecordCodec codec : {RecordCodec::raw, RecordCodec::predicted}) {
    EXPECT_FALSE(unpack(pack(brickOf(band), band, codec), band, back)) << "no voxel in the band";
    EXPECT_FALSE(unpack(pack(brickOf(-band), band, codec), band, back));
    for (const float wrong :
         {std::numeric_limits<float>::quiet_NaN(), -std::numeric_limits<float>::quiet_NaN(),
          std::numeric_limits<float>::infinity(), std::nextafter(band, 4.0f), -std::nextafter(band, 4.0f), -0.0f}) {
      FloatBrick brick = sound;
      brick.value[511] = wrong;
      EXPECT_FALSE(unpack(pack(brick, band, codec), band, back)) << wrong;
    }
    Packed packed = pack(sound, band, codec);
    EXPECT_FALSE(unpack(packed, band, back, RecordKind::node));
    EXPECT_FALSE(unpack(packed, 2, back)) << "another band";
    packed.body.push_back(std::byte{0});
    EXPECT_FALSE(unpack(packed, band, back)) << "longer";
    packed.body.pop_back();
    while (!packed.body.empty()) {
      packed.body.pop_back();
      EXPECT_FALSE(unpack(packed, band, back)) << "cut at " << packed.body.size();
    }
  }
  Packed packed = pack(sound, band, RecordCodec::raw);
  packed.codec = RecordCodec::zstd;
  EXPECT_FALSE(unpack(packed, band, back));
}

TEST(BrickCodec, AnyBytesAreReadOrRefused) {
  std::mt19937 random(20261120);
  const float band = 3;
  FloatBrick sound = brickOf(band);
  for (int i = 0; i < kBrickVoxels; ++i)
    sound.value[i] = std::clamp(static_cast<float>(i % 8) - 3.5f + 0.1f * static_cast<float>(i / 64), -band, band);
  const Packed packed = pack(sound, band, RecordCodec::predicted);
  int read = 0;
  for (int round = 0; round < 20000; ++round) {
    Packed changed = packed;
    if (round % 4 == 0) changed.body.resize(12 + random() % 2200);
    for (unsigned i = 0; i < 1 + random() % 4; ++i)
      changed.body[random() % changed.body.size()] ^= static_cast<std::byte>(1u << random() % 8);
    if (round % 5 == 0)
      for (size_t i = 12; i < changed.body.size(); ++i) changed.body[i] = static_cast<std::byte>(random());
    FloatBrick back;
    if (!unpack(changed, band, back)) continue;
    ++read;
    bool inBand = false;
    for (const float phi : back.value) {
      ASSERT_LE(std::abs(phi), band);
      inBand |= std::abs(phi) < band;
    }
    ASSERT_TRUE(inBand);
  }
  EXPECT_GT(read, 10);
}

}  // namespace
}  // namespace argil::io
