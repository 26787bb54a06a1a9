// The three hand-offs between threads.

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <thread>

#include "haptics/threads/latest_value.h"
#include "haptics/threads/published.h"
#include "haptics/threads/sample_ring.h"

namespace argil::haptics {
namespace {

struct Pair {
  uint64_t a = 0, b = 0;
};

TEST(LatestValue, NeverTearsAndNeverGoesBack) {
  LatestValue<Pair> value;
  std::atomic<bool> done{false};
  std::thread writer([&] {
    for (uint64_t i = 1; i <= 200'000; ++i) value.store({i, ~i});
    done = true;
  });
  uint64_t last = 0, seen = 0;
  Pair pair{0, 0};
  bool finished = false;
  while (!finished) {
    finished = done;
    if (!value.load(pair)) continue;
    ++seen;
    ASSERT_EQ(pair.b, ~pair.a);
    ASSERT_GT(pair.a, last);
    last = pair.a;
  }
  writer.join();
  EXPECT_EQ(last, 200'000u) << "the last value arrives";
  EXPECT_FALSE(value.load(pair)) << "and is not new a second time";
  EXPECT_EQ(pair.a, 200'000u);
}

TEST(SampleRing, HoldsEightSecondsAndCountsWhatItDrops) {
  SampleRing ring(8000);
  EXPECT_GE(ring.capacity(), 64'000u);
  BoundedRing<uint64_t> small(8);
  for (uint64_t i = 0; i < 11; ++i) EXPECT_EQ(small.push(i), i < 8);
  EXPECT_EQ(small.dropped(), 3u);
  EXPECT_EQ(small.size(), 8u);
  uint64_t out[5];
  EXPECT_EQ(small.pop(out), 5u);
  EXPECT_EQ(out[4], 4u);
  EXPECT_TRUE(small.push(99));
  EXPECT_EQ(small.pop(out), 4u);
  EXPECT_EQ(out[3], 99u);
}

TEST(SampleRing, KeepsOrderBetweenThreads) {
  BoundedRing<uint64_t> ring(64);
  std::thread producer([&] {
    for (uint64_t i = 0; i < 100'000;) {
      if (ring.push(i))
        ++i;
      else
        std::this_thread::yield();
    }
  });
  uint64_t wanted = 0, out[16];
  while (wanted < 100'000) {
    const size_t n = ring.pop(out);
    for (size_t i = 0; i < n; ++i) ASSERT_EQ(out[i], wanted++);
    if (n == 0) std::this_thread::yield();
  }
  producer.join();
}

struct Watched {
  static std::atomic<int> alive;
  static std::atomic<std::thread::id> freedBy;
  uint64_t number;
  explicit Watched(uint64_t n) : number(n) { ++alive; }
  ~Watched() {
    --alive;
    freedBy = std::this_thread::get_id();
    number = 0;
  }
};
std::atomic<int> Watched::alive{0};
std::atomic<std::thread::id> Watched::freedBy{};

TEST(Published, FreesOnlyWhatEveryReaderHasPassed) {
  Watched::alive = 0;
  {
    Published<Watched> published;
    Published<Watched>::Reader reader(published), other(published);
    EXPECT_EQ(reader.enter(), nullptr);
    published.publish(std::make_unique<const Watched>(1));
    EXPECT_EQ(reader.enter()->number, 1u);
    published.publish(std::make_unique<const Watched>(2));
    EXPECT_EQ(Watched::alive, 2) << "the first is still being read";
    EXPECT_EQ(published.reclaim(), 1u);
    EXPECT_EQ(reader.enter()->number, 2u);
    EXPECT_EQ(published.reclaim(), 0u);
    EXPECT_EQ(Watched::alive, 1);
    // A parked reader holds nothing: nothing piles up behind a stopped servo.
    reader.park();
    for (uint64_t i = 3; i < 100; ++i) published.publish(std::make_unique<const Watched>(i));
    EXPECT_EQ(Watched::alive, 1);
    EXPECT_EQ(reader.enter()->number, 99u);
    // A reader that stays holds back what came after it, until it moves on.
    for (uint64_t i = 100; i < 110; ++i) published.publish(std::make_unique<const Watched>(i));
    EXPECT_EQ(Watched::alive, 11);
    (void)reader.enter();
    EXPECT_EQ(published.reclaim(), 0u);
  }
  EXPECT_EQ(Watched::alive, 0);
}

TEST(Published, AReaderNeverSeesAFreedOneAndNeverFrees) {
  Watched::alive = 0;
  Published<Watched> published;
  published.publish(std::make_unique<const Watched>(1));
  std::atomic<bool> stop{false};
  std::atomic<uint64_t> reads{0}, bad{0};
  std::thread::id readerId;
  std::thread thread([&] {
    Published<Watched>::Reader reader(published);
    uint64_t last = 0;
    for (uint64_t i = 0; !stop; ++i) {
      const Watched* w = reader.enter();
      if (w->number < last || w->number == 0) ++bad;
      last = w->number;
      if (w->number == 0) ++bad;
      ++reads;
      if (i % 64 == 0) reader.park();
    }
  });
  readerId = thread.get_id();
  for (uint64_t i = 2; i < 20'000 || reads < 1000; ++i) published.publish(std::make_unique<const Watched>(i));
  stop = true;
  thread.join();
  EXPECT_EQ(bad, 0u);
  EXPECT_NE(Watched::freedBy.load(), readerId);
  published.reclaim();
  EXPECT_EQ(Watched::alive, 1);
}

TEST(Published, SaysWhenThereAreTooManyReaders) {
  Published<Watched> published;
  std::vector<std::unique_ptr<Published<Watched>::Reader>> readers;
  for (size_t i = 0; i < Published<Watched>::kMaxReaders; ++i)
    readers.push_back(std::make_unique<Published<Watched>::Reader>(published));
  EXPECT_THROW(Published<Watched>::Reader one(published), Error);
  readers.pop_back();
  EXPECT_NO_THROW(Published<Watched>::Reader one(published));
}

}  // namespace
}  // namespace argil::haptics
