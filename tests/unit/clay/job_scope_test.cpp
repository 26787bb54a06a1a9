// Surfaces that are cancelled while they are made.

#include "clay/base/job_scope.h"

#include <gtest/gtest.h>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"

namespace argil::clay {
namespace {

TEST(JobScope, ACancelledSurfaceThrowsAndStartsAnew) {
  Grid grid;
  grid.voxelMm = 0.25;
  const Version ball = makeSphere(Store::make(), grid, Vec3d::Zero(), 25);
  Surface whole(true, Grade::crisp), cut(true, Grade::crisp);
  whole.update(ball, 2);
  for (const int threads : {1, 2, 4}) {
    Job job;
    {
      const JobScope scope(&job);
      EXPECT_EQ(JobScope::current(), &job);
      job.cancel();
      EXPECT_THROW((void)cut.update(ball, threads), Cancelled);
      {
        const JobScope none(nullptr);
        EXPECT_NO_THROW((void)Surface(true, Grade::crisp).update(ball, threads));
      }
      EXPECT_EQ(JobScope::current(), &job);
    }
    EXPECT_EQ(JobScope::current(), nullptr);
    cut.update(ball, threads);
    EXPECT_EQ(cut.hash(), whole.hash());
    cut = Surface(true, Grade::crisp);
  }
}

}  // namespace
}  // namespace argil::clay
