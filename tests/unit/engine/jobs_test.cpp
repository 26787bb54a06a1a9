#include "engine/document/jobs.h"

#include <gtest/gtest.h>
#include <sys/resource.h>

#include <algorithm>
#include <chrono>
#include <thread>

namespace argil::engine {
namespace {

using namespace std::chrono_literals;

void workUntilCancelled(Job& job) {
  for (;;) {
    job.step(0.5);
    std::this_thread::sleep_for(1ms);
  }
}

TEST(BackgroundJob, TellsItsProgressAndItsEnd) {
  std::atomic<bool> go{false};
  BackgroundJob job([&](Job& progress) {
    progress.step(0.25);
    while (!go) std::this_thread::sleep_for(1ms);
    progress.step(1);
  });
  while (job.job().fraction() < 0.25) std::this_thread::sleep_for(1ms);
  EXPECT_FALSE(job.done());
  go = true;
  job.wait();
  EXPECT_TRUE(job.done());
  EXPECT_EQ(job.job().fraction(), 1);
}

// Behind the threads of the hand; but not at 15 of 1024 parts of what another program's thread gets, as nice 19 is.
TEST(BackgroundJob, StandsBehindTheHandButDoesNotStarve) {
  const int own = getpriority(PRIO_PROCESS, 0);
  int work = 0, helper = 0;
  BackgroundJob job([&](Job&) {
    work = getpriority(PRIO_PROCESS, 0);
    std::thread([&] { helper = getpriority(PRIO_PROCESS, 0); }).join();
  });
  job.wait();
  if (own < 5) {  // Else it stands there already.
    EXPECT_GT(work, own);
  }
  EXPECT_LE(work, std::max(own, 10));
  EXPECT_EQ(helper, work);
}

TEST(BackgroundJob, CarriesAnExceptionToTheWaiter) {
  BackgroundJob job([](Job&) { throw Error("no clay left"); });
  for (int again = 0; again < 2; ++again) {
    try {
      job.wait();
      FAIL() << "nothing was thrown";
    } catch (const Error& error) {
      EXPECT_STREQ(error.what(), "no clay left");
    }
  }
}

TEST(BackgroundJob, StopsWhenCancelled) {
  BackgroundJob job(workUntilCancelled);
  job.job().cancel();
  EXPECT_THROW(job.wait(), Cancelled);
}

TEST(BackgroundJob, IsCancelledByItsDestructor) {
  const auto start = std::chrono::steady_clock::now();
  { const BackgroundJob job(workUntilCancelled); }
  EXPECT_LT(std::chrono::steady_clock::now() - start, 5s);
}

}  // namespace
}  // namespace argil::engine
