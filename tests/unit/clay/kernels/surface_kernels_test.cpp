// Kernels of extraction against plain loops, on every SIMD target of this machine.

#include "clay/kernels/surface_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <random>
#include <vector>

#include "tests/support/simd_targets.h"

namespace argil::clay {
namespace {

constexpr unsigned kSeed = 17;
constexpr uint16_t kUntouched = 0xabcd;

/// None, all, few or many bits in each of eight words.
std::array<uint64_t, 8> randomWords(std::mt19937_64& random) {
  std::array<uint64_t, 8> words;
  for (uint64_t& word : words) {
    const uint64_t kind = random() % 5;
    word = kind == 0   ? 0
           : kind == 1 ? ~uint64_t{0}
           : kind == 2 ? random() & random() & random()
           : kind == 3 ? random()
                       : uint64_t{1} << (random() % 64);
  }
  return words;
}

template <class Visit>
void forEachBit(const std::array<uint64_t, 8>& words, const Visit& visit) {
  for (int x = 0; x < 8; ++x)
    for (int bit = 0; bit < 64; ++bit)
      if (words[static_cast<size_t>(x)] >> bit & 1) visit(x, bit);
}

TEST(SurfaceKernels, ListWhatIsSet) {
  tests::forEachSimdTarget([](const std::string& target) {
    std::mt19937_64 random(kSeed);
    for (int run = 0; run < 300; ++run) {
      const auto words = randomWords(random), inside = randomWords(random);
      std::vector<uint16_t> bits, edges;
      forEachBit(words, [&](int x, int bit) {
        bits.push_back(static_cast<uint16_t>(x * 64 + bit));
        const bool up = inside[static_cast<size_t>(x)] >> bit & 1;
        edges.push_back(static_cast<uint16_t>(mapPlace(x, bit >> 3, bit & 7) | (up ? 0 : kEdgeDown)));
      });
      std::array<uint16_t, 512 + kListPadding + 1> out;
      const auto expect = [&](int count, const std::vector<uint16_t>& wanted) {
        ASSERT_EQ(static_cast<size_t>(count), wanted.size()) << target << ", run " << run;
        EXPECT_TRUE(std::equal(wanted.begin(), wanted.end(), out.begin())) << target << ", run " << run;
        EXPECT_EQ(out[static_cast<size_t>(count) + kListPadding], kUntouched) << target << ", run " << run;
      };
      out.fill(kUntouched);
      expect(listBits(words.data(), out.data()), bits);
      out.fill(kUntouched);
      expect(listEdges(words.data(), inside.data(), out.data()), edges);
    }
  });
}

TEST(SurfaceKernels, PlaceEachVertexAtItsCellAndTouchNothingElse) {
  tests::forEachSimdTarget([](const std::string& target) {
    std::mt19937_64 random(kSeed + 1);
    std::uniform_real_distribution<float> at(-1, 9);
    for (int run = 0; run < 200; ++run) {
      const auto words = randomWords(random);
      std::vector<float> positions;
      std::vector<CellVertex> map(729, CellVertex{-7, -7, -7, 0}), wanted = map;
      const uint32_t refs = kRefTag | (run % 8) << 13;
      forEachBit(words, [&](int x, int bit) {
        const auto number = static_cast<uint32_t>(positions.size() / 3);
        const CellVertex vertex{at(random), at(random), at(random), refs | number};
        wanted[static_cast<size_t>(mapPlace(x, bit >> 3, bit & 7))] = vertex;
        positions.insert(positions.end(), {vertex.x, vertex.y, vertex.z});
      });
      positions.shrink_to_fit();  // whoever reads behind the last is caught by a sanitizer
      placeCells(positions.data(), words.data(), refs, map.data());
      EXPECT_EQ(std::memcmp(map.data(), wanted.data(), map.size() * sizeof(CellVertex)), 0) << target << ", " << run;
    }
  });
}

// Whatever is unusual is said to be there; what no cell has is not (where a target asks at all).
TEST(SurfaceKernels, SayWhetherSomeCellIsUnusual) {
  tests::forEachSimdTarget([](const std::string& target) {
    std::mt19937_64 random(kSeed + 2);
    std::uniform_real_distribution<float> value(-0.4f, 0.4f);
    size_t without = 0;
    for (int run = 0; run < 300; ++run) {
      std::array<float, kCornerCount> corners;
      for (float& each : corners) each = value(random);
      const int count = 1 + static_cast<int>(random() % 40);
      std::vector<uint16_t> cells(64);
      for (uint16_t& cell : cells) cell = static_cast<uint16_t>(random() % 512);
      std::fill(cells.begin() + count, cells.end(), cells[0]);
      std::array<uint32_t, 8> unusual{};
      const auto marked = static_cast<uint32_t>(random() % 256);
      unusual[marked >> 5] |= 1u << (marked & 31);
      std::vector<uint32_t> patterns(64);
      std::vector<float> positions(3 * 64);
      const bool kinks = run % 2 == 1;
      const bool some = cellVertices(corners.data(), cells.data(), count, kinks, unusual.data(), patterns.data(),
                                     positions.data(), nullptr);
      const bool wanted = std::any_of(patterns.begin(), patterns.begin() + count,
                                      [&](uint32_t pattern) { return pattern > 0xff || pattern == marked; });
      EXPECT_TRUE(some || !wanted) << target << ", run " << run;
      without += !some;
      for (int i = 0; i < count; ++i) {
        const int x = cells[size_t(i)] >> 6, y = cells[size_t(i)] >> 3 & 7, z = cells[size_t(i)] & 7;
        uint32_t pattern = 0;
        for (int c = 0; c < 8; ++c)
          pattern |= uint32_t{corners[size_t(cornerOffset(x + (c >> 2), y + (c >> 1 & 1), z + (c & 1)))] < 0} << c;
        ASSERT_EQ(patterns[size_t(i)] & 0xff, pattern) << target;
      }
    }
    if (target.find("AVX") != std::string::npos) {
      EXPECT_GT(without, 100u) << target;
    }
  });
}

}  // namespace
}  // namespace argil::clay
