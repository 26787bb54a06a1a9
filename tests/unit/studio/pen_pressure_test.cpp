// What a pen's pressure does as each tool begins, and that nothing changes for who has no pressure.

#include <gtest/gtest.h>

#include <limits>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/saving/session.h"
#include "engine/tools/tool_table.h"
#include "tests/support/tool_files.h"
#include "ui3d/studio/quick_ring.h"
#include "ui3d/studio/view/studio_state.h"

namespace argil::engine {
namespace {

// A ball with a groove, a rim between two colours and one of a mask: something for every tool to do.
const clay::Version& workpiece() {
  static const clay::Version made = [] {
    Session session(Document::of(clay::makeSphere(clay::Store::make(), {.voxelMm = 0.5}, Vec3d::Zero(), 15)));
    const auto stroke = [&](const char* id, uint32_t colour, double y) {
      Tool tool = scriptTool(*findTool(id));
      tool.radiusMm = 2;
      tool.colour = colour;
      session.beginStroke(tool);
      for (int i = 0; i <= 10; ++i) session.addPoint(0.01 * i, {-6 + 1.2 * i, y, 14});
      session.endStroke();
    };
    stroke("carve", 0, 1);
    stroke("paint", 0xc8402e, -1);
    stroke("paint", 0x20a040, 2);
    stroke("mask", 0, -3);
    return session.version();
  }();
  return made;
}

uint64_t worked(Tool tool, double pressure) {
  tests::giveFile(tool);
  tool.radiusMm = 3;
  Session session(Document::of(workpiece()));
  // Something to go back from.
  Tool first = scriptTool(*findTool("carve"));
  first.radiusMm = 2;
  session.beginStroke(first);
  for (int i = 0; i <= 5; ++i) session.addPoint(0.01 * i, {-3 + 1.2 * i, -1, 14});
  session.endStroke();
  session.beginStroke(tool);
  for (int i = 0; i <= 12; ++i) {
    PathPoint point{0.01 * i, {-5 + 0.8 * i, -2 + 0.3 * i, 14}};
    point.pressure = pressure;
    session.addPoint(point);
  }
  session.endStroke();
  return session.version().hash();
}

TEST(PenPressure, EveryToolFollowsItAsItBegins) {
  for (const ToolRow& row : toolTable()) {
    SCOPED_TRACE(row.id);
    const Tool tool = standardTool(row);
    const uint64_t light = worked(tool, 0.2), heavy = worked(tool, 0.9);
    if (pressureRules(row) == PressureRules::depth) {
      EXPECT_EQ(row.work, haptics::Work::cut) << "only what cuts can be pressed deeper";
    } else {
      EXPECT_NE(light, heavy);
    }
    // Who names no pressure gets what there was before there were defaults.
    const uint64_t plain = worked(scriptTool(row), 1);
    EXPECT_EQ(worked(tool, 1), plain);
    EXPECT_EQ(worked(scriptTool(row), 0.2), plain);
  }
}

TEST(PenPressure, TheCurveLeavesTheEndsAndBendsTheMiddle) {
  for (const double curve : {-1.0, -0.3, 0.0, 0.5, 1.0}) {
    EXPECT_EQ(curvedPressure(curve, 0), 0);
    EXPECT_EQ(curvedPressure(curve, 1), 1);
  }
  EXPECT_NEAR(curvedPressure(0, 0.4), 0.4, 1e-15);
  EXPECT_GT(curvedPressure(-1, 0.3), 0.6);
  EXPECT_LT(curvedPressure(1, 0.3), 0.1);
}

}  // namespace
}  // namespace argil::engine

namespace argil::studio {
namespace {

TEST(ToolSizes, GoWithTheModelAndComeBack) {
  StudioState state;
  state.tool().radiusMm = 4;
  state.sizeTools(1);
  EXPECT_NEAR(state.tool().radiusMm, 4 / 96.0, 1e-12);
  state.toolId = "inflate";
  EXPECT_NEAR(state.tool().radiusMm, 5 / 96.0, 1e-12) << "one that was never taken";
  EXPECT_NEAR(state.tool().heightMm, 1.5 / 96.0, 1e-12);
  state.sizeTools(2000);
  EXPECT_NEAR(state.tool().radiusMm, 5 * 2000 / 96.0, 1e-9);
  state.sizeTools(96);
  EXPECT_NEAR(state.tool().radiusMm, 5, 1e-9);
  state.sizeTools(0);
  state.sizeTools(std::numeric_limits<double>::quiet_NaN());
  EXPECT_EQ(state.sizedForMm, 96);
}

TEST(QuickRing, EachItemIsWhereItIsDrawnAndTheRingStaysInTheWindow) {
  using Item = QuickRing::Item;
  for (const auto& [x, y] : {std::pair{400.f, 300.f}, {0.f, 0.f}, {1279.f, 719.f}}) {
    const QuickRing ring = QuickRing::around(x, y, 1280, 720);
    EXPECT_GE(ring.x - QuickRing::kOuter, 0);
    EXPECT_LE(ring.y + QuickRing::kOuter, 720);
    for (int i = 1; i <= QuickRing::kItems; ++i) {
      const auto [px, py] = ring.place(Item(i));
      EXPECT_EQ(ring.at(px, py), Item(i)) << QuickRing::name(Item(i));
    }
    EXPECT_EQ(ring.at(ring.x, ring.y), Item::none);
    EXPECT_EQ(ring.at(ring.x + QuickRing::kOuter + 1, ring.y), Item::none);
  }
  EXPECT_EQ(QuickRing::around(50, 50, 100, 80).shown < 0.5f, true) << "no room";
}

}  // namespace
}  // namespace argil::studio
