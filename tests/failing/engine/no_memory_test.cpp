// Every allocation of a piece of work fails once: nothing ends the program, what was there stays, and the same work
// succeeds afterwards with the same result. Imports are not among it: OpenVDB's trees do not survive an allocation that
// fails while a node is made.

#include <gtest/gtest.h>

#include <array>
#include <cstddef>
#include <functional>
#include <optional>

#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/field/scratch.h"
#include "clay/store/editor.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "clay/whole/boolean.h"
#include "clay/whole/offset.h"
#include "clay/whole/resample.h"
#include "clay/whole/smooth_all.h"
#include "engine/saving/session.h"
#include "engine/tools/tool_table.h"
#include "tests/support/own_new.h"
#include "tests/support/tier.h"

namespace argil::engine {
namespace {

using clay::Version;

constexpr size_t kEach = 150;  // Of the first so many allocations each fails, later ones by steps.

Version ball(double radius = 4) {
  clay::Grid grid;
  grid.voxelMm = 0.5;
  return clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), radius);
}

// `work` until it gets through; `after` each time that it did not. Returns how often it failed.
int failing(const std::function<void()>& work, const std::function<void()>& after) {
  int failed = 0;
  const size_t step = tests::byTier(23, 3);
  for (size_t nth = 1;; nth += nth < kEach ? 1 : step) {
    bool refused = false;
    {
      const tests::FailingMemory memory(nth);
      try {
        work();
      } catch (const std::bad_alloc&) {
      } catch (const Error&) {
      }
      refused = memory.refused();
    }
    after();
    if (!refused) return failed;
    ++failed;
  }
}

class NoMemory : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!tests::memoryCanFail()) GTEST_SKIP() << "operator new is a sanitizer's";
  }
};

TEST_F(NoMemory, AStrokeLeavesTheClayAsItWasOrIsDone) {
  for (const ToolRow& row : toolTable()) {
    if (row.file != ToolFile::none) continue;
    SCOPED_TRACE(row.id);
    Tool tool = standardTool(row);
    tool.radiusMm = 1.5;
    const auto stroke = [&](Session& session) {
      session.beginStroke(tool);
      for (int i = 0; i < 4; ++i) session.addPoint(0.01 * i, Vec3d(3.9, 0.4 * i, 0.1 * i));
      session.publish();
      session.endStroke();
    };
    const Version begin = ball();
    Session reference(begin);
    stroke(reference);
    const uint64_t done = reference.version().hash();
    std::optional<Session> session(begin);
    const int failed = failing([&] { stroke(*session); },
                               [&] {
                                 if (session->inStroke()) session->abandonStroke();
                                 const uint64_t now = session->version().hash();
                                 EXPECT_TRUE(now == begin.hash() || now == done);
                                 EXPECT_EQ(session->undoSteps() > 0, now != begin.hash());
                                 while (session->undo()) {
                                 }
                                 EXPECT_EQ(session->version().hash(), begin.hash());
                               });
    EXPECT_GT(failed, 10);
    stroke(*session);
    EXPECT_EQ(session->version().hash(), done);
  }
}

// A stamp in many steps, some of which have been seen: it is there, or what was seen of it is gone.
TEST_F(NoMemory, AStampInStepsIsDoneOrUndone) {
  for (const clay::Method method : {clay::Method::smooth, clay::Method::raise, clay::Method::tug, clay::Method::add}) {
    SCOPED_TRACE(int(method));
    const auto brush = clay::Brush::of(method);
    const Version begin = ball(17);
    const clay::Stamp stamp{Vec3d(34, 0, 0), Vec3d(33, 4, 0), 64, 0.2f};
    uint64_t done = 0;
    const auto stamped = [&] {
      clay::BrushStroke stroke(begin, brush);
      bool looks = false;
      try {
        for (int steps = 0; stroke.step({&stamp, 1}); ++steps) {
          looks = true;
          if (steps % 3 == 0) (void)stroke.publish();
          looks = false;
        }
      } catch (...) {
        // A look that fails takes nothing away: the stamp is in work yet.
        if (looks) {
          EXPECT_EQ(stroke.finish().hash(), done);
        } else {
          EXPECT_EQ(stroke.publish().hash(), begin.hash());
        }
        throw;
      }
      return stroke.finish().hash();
    };
    done = stamped();
    EXPECT_NE(done, begin.hash());
    EXPECT_GT(failing([&] { EXPECT_EQ(stamped(), done); }, [] {}), 10);
  }
}

TEST_F(NoMemory, WholePiecesStayAsTheyAre) {
  const Version a = ball(), b = ball(3);
  const uint64_t before = a.hash();
  clay::Editor editor(a);
  std::array<uint8_t, clay::kBrickVoxels> values;
  values.fill(77);
  a.forEachBrick([&](const clay::Brick& brick) { editor.setChannel(clay::Channel::red, brick.coord, values); });
  const Version painted = editor.commit();
  clay::Grid coarse = a.grid();
  coarse.voxelMm = 0.75;
  const Eigen::Isometry3d still = Eigen::Isometry3d::Identity();
  const auto tryAll = [&](const char* name, const std::function<Version()>& work) {
    SCOPED_TRACE(name);
    const uint64_t done = work().hash();
    std::optional<uint64_t> result;
    const int failed = failing([&] { result = work().hash(); }, [&] { EXPECT_EQ(a.hash(), before); });
    EXPECT_GT(failed, 10);
    EXPECT_EQ(result, done);
  };
  tryAll("join", [&] { return clay::combine(a, b, clay::Combination::join); });
  tryAll("cut", [&] { return clay::combine(a, b, clay::Combination::cut); });
  tryAll("thicken", [&] { return clay::offset(a, 0.7, 1); });
  tryAll("smooth", [&] { return clay::smoothAll(a, 5, true, 1); });
  tryAll("smooth colours", [&] { return clay::smoothAll(painted, 5, true, 1); });
  tryAll("resample colours", [&] { return clay::resample(painted, coarse, still, 1); });
  tryAll("resample", [&] { return clay::resample(a, coarse, still, 1); });
}

TEST_F(NoMemory, ASurfaceIsThereTheNextTime) {
  const Version a = ball(), b = clay::combine(a, ball(3), clay::Combination::cut);
  clay::Surface fresh(true, clay::Grade::crisp);
  fresh.update(b);
  clay::Surface surface(true, clay::Grade::crisp);
  const int failed = failing(
      [&] {
        surface.update(a);
        surface.update(b);
      },
      [] {});
  EXPECT_GT(failed, 10);
  EXPECT_EQ(surface.hash(), fresh.hash());
}

// Whoever gives up gives back, and needs nothing for it: neither for bricks that were made nor for those in stock.
TEST_F(NoMemory, AnEditorGoesWithoutMemory) {
  for (const int count : {1, 40, 700, 5000}) {
    const Version clay = ball(8);
    std::optional<clay::Editor> editor(clay);
    std::array<float, clay::kBrickVoxels> values{};
    for (int v = 0; v < clay::kBrickVoxels; ++v) values[size_t(v)] = 0.01f * float(v % 90);
    for (int i = 0; i < count; ++i) editor->setVoxels({100 + i % 20, 100 + i / 20 % 20, 100 + i / 400}, values);
    {
      const tests::FailingMemory none(1, true);
      editor.reset();
    }
    while (clay.store()->collect()) {
    }
    clay::Editor again(clay);
    again.setVoxels({100, 100, 100}, values);
    EXPECT_TRUE(again.commit());
  }
}

TEST_F(NoMemory, ARoomThatCouldNotGrowIsAskedForAnew) {
  const auto room = [](size_t bytes) { return clay::Scratch::of<std::byte>(bytes, clay::Scratch::Room::bricks); };
  (void)room(1 << 10);
  {
    const tests::FailingMemory memory(1);
    EXPECT_THROW((void)room(1 << 24), std::bad_alloc);
  }
  EXPECT_NE(room(1 << 12).data(), nullptr);
}

}  // namespace
}  // namespace argil::engine
