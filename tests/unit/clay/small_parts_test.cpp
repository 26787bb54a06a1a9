// The small things that the rest of the room stands on.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <numeric>
#include <random>
#include <set>
#include <stdexcept>
#include <thread>

#include "clay/base/block_pool.h"
#include "clay/base/hash.h"
#include "clay/base/job.h"
#include "clay/base/parallel.h"
#include "clay/store/brick_set.h"
#include "clay/store/editor.h"

namespace argil::clay {
namespace {

TEST(BrickSet, HoldsEachOnceInAnOrderOfItsOwn) {
  std::mt19937_64 random(1);
  std::vector<Coord> added;
  for (int i = 0; i < 2000; ++i)
    added.push_back({static_cast<int>(random() % 40) - 20, static_cast<int>(random() % 40) - 20,
                     static_cast<int>(random() % 40) - 20});
  BrickSet forwards, backwards;
  for (size_t i = 0; i < added.size(); ++i) {
    forwards.add(added[i]);
    backwards.add(added[added.size() - 1 - i]);
  }
  const std::vector<Coord> sorted = forwards.sorted();
  EXPECT_EQ(sorted, backwards.sorted());
  EXPECT_EQ(std::set<Coord>(sorted.begin(), sorted.end()), std::set<Coord>(added.begin(), added.end()));
  EXPECT_EQ(std::set<Coord>(sorted.begin(), sorted.end()).size(), sorted.size());
}

TEST(ParallelBlocks, CoversEachIndexOnce) {
  for (const int threads : {1, 2, 4, 7}) {
    std::vector<std::atomic<int>> seen(10007);
    parallelBlocks(
        seen.size(), threads,
        [&](size_t begin, size_t end) {
          for (size_t i = begin; i < end; ++i) ++seen[i];
        },
        64);
    for (const auto& n : seen) ASSERT_EQ(n.load(), 1);
  }
}

TEST(ParallelBlocks, CarriesAFailureOut) {
  const auto fail = [](size_t begin, size_t) {
    if (begin >= 640) throw std::runtime_error("planted");
  };
  EXPECT_THROW(parallelBlocks(10000, 3, fail, 64), std::runtime_error);
  EXPECT_THROW(parallelBlocks(10000, 1, [](size_t, size_t) { throw std::runtime_error("planted"); }),
               std::runtime_error);
}

TEST(BlockPool, BlocksAreAlignedApartAndUsedAgain) {
  const auto pool = BlockPool::make();
  BlockPool::Share share(*pool);
  std::mt19937_64 random(2);
  std::vector<std::pair<unsigned char*, size_t>> held;
  for (int i = 0; i < 5000; ++i) {
    const size_t bytes = 1 + random() % (i % 100 == 0 ? 100000 : 3000);
    auto* block = static_cast<unsigned char*>(share.allocate(bytes));
    ASSERT_EQ(reinterpret_cast<uintptr_t>(block) % 64, 0u);
    std::fill_n(block, bytes, static_cast<unsigned char>(bytes));
    held.emplace_back(block, bytes);
    if (random() % 2) {
      const size_t k = random() % held.size();
      // Nobody else wrote there.
      for (size_t j = 0; j < held[k].second; ++j)
        ASSERT_EQ(held[k].first[j], static_cast<unsigned char>(held[k].second));
      pool->release(held[k].first, held[k].second);
      held[k] = held.back();
      held.pop_back();
    }
  }
  void* last = share.allocate(500);
  pool->release(last, 500);
  EXPECT_EQ(share.allocate(500), last);
  pool->release(last, 500);
  for (const auto& [block, bytes] : held) pool->release(block, bytes);
}

// Two threads that allocate at once get memory apart, and what they hold outlives the pool's owner: the next pool gets
// none of it.
TEST(BlockPool, SharesLieApartAndBlocksOutliveTheOwner) {
  auto pool = BlockPool::make();
  constexpr size_t kBytes = 192;
  std::vector<std::vector<unsigned char*>> held(2);
  {
    std::vector<std::jthread> threads;
    for (size_t t = 0; t < 2; ++t)
      threads.emplace_back([&, t] {
        BlockPool::Share share(*pool);
        for (int i = 0; i < 30000; ++i) {
          held[t].push_back(static_cast<unsigned char*>(share.allocate(kBytes)));
          std::fill_n(held[t].back(), kBytes, static_cast<unsigned char>(t + 1));
          if (i % 3 == 0) {
            pool->release(held[t].back(), kBytes);
            held[t].pop_back();
          }
        }
      });
  }
  BlockPool* const raw = pool.get();
  pool.reset();
  {
    const auto next = BlockPool::make();
    BlockPool::Share share(*next);
    std::vector<void*> others;
    for (int i = 0; i < 60000; ++i) {
      others.push_back(share.allocate(kBytes));
      std::memset(others.back(), 9, kBytes);
    }
    for (void* block : others) next->release(block, kBytes);
  }
  std::set<unsigned char*> places;
  for (size_t t = 0; t < 2; ++t)
    for (unsigned char* block : held[t]) {
      ASSERT_TRUE(std::all_of(block, block + kBytes, [t](unsigned char c) { return c == t + 1; }));
      ASSERT_TRUE(places.insert(block).second);
      raw->release(block, kBytes);
    }
}

TEST(Editor, BlocksHoldTheirBricks) {
  std::mt19937_64 random(3);
  for (int i = 0; i < 1000; ++i) {
    const auto c = [&] { return static_cast<int>(random() % (2 * kBrickReach)) - kBrickReach; };
    const Coord brick{c(), c(), c()};
    for (int level = 0; level <= kTreeLevels; ++level) {
      const Coord inside = brick - Editor::blockFirst(brick, level);
      for (const int x : {inside.x, inside.y, inside.z}) ASSERT_TRUE(x >= 0 && x < 1 << (3 * level));
    }
    ASSERT_EQ(Editor::blockFirst(brick, 0), brick);
    ASSERT_EQ(Editor::blockFirst(brick, 1), (brick >> 3) * 8);
  }
}

TEST(Hasher, DependsOnEveryByteAndOnTheOrder) {
  const char text[] = "digital clay that you touch";
  const auto of = [](const char* data, size_t n) {
    Hasher h;
    h.add(data, n);
    return h.value();
  };
  const uint64_t whole = of(text, sizeof text);
  for (size_t i = 0; i < sizeof text; ++i) {
    char changed[sizeof text];
    std::copy(std::begin(text), std::end(text), changed);
    changed[i] ^= 1;
    EXPECT_NE(of(changed, sizeof changed), whole) << i;
  }
  Hasher a, b;
  a.add(1);
  a.add(2);
  b.add(2);
  b.add(1);
  EXPECT_NE(a.value(), b.value());
}

TEST(Job, LeavesOnceCancelled) {
  Job job;
  job.step(0.25);
  EXPECT_EQ(job.fraction(), 0.25);
  job.cancel();
  EXPECT_THROW(job.step(0.5), Cancelled);
}

}  // namespace
}  // namespace argil::clay
