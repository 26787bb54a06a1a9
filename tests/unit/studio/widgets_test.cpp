// Widgets on a real workbench and a real renderer.

#include "ui3d/studio/widgets/widgets.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/unit/studio/widget_rig.h"
#include "ui3d/studio/view/camera.h"

namespace argil::studio {
namespace {

using engine::Guide;
using test::kHeight;
using test::kWidth;
using test::Rig;

engine::Workbench::Options quiet() {
  engine::Workbench::Options options;
  options.realtime = false;
  return options;
}

/// Until the bench has nothing to do; generous, as the machine may be busy.
bool settle(engine::Workbench& bench) {
  const auto until = std::chrono::steady_clock::now() + std::chrono::minutes(5);
  int quietLooks = 0;
  while (quietLooks < 3) {
    if (std::chrono::steady_clock::now() > until) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(2));
    quietLooks = bench.idle() ? quietLooks + 1 : 0;
  }
  return true;
}

engine::Id addPlane(engine::Workbench& bench) {
  const engine::Id id = bench.snapshot()->document->nextId;
  bench.edit("Add a plane", [](engine::Document& document) {
    Guide guide;
    guide.feel = Guide::Feel::lock;
    document.add(guide);
  });
  return settle(bench) && bench.snapshot()->document->guide(id) ? id : 0;
}

TEST(Widgets, ADragOfAHundredEventsIsOneUndoStepOfTheWorkbench) {
  engine::Workbench bench(quiet());
  Rig rig(render::View::named("iso", Rig::box(100), kWidth / kHeight));
  rig.bench = &bench;
  const engine::Id id = rig.state.selected = addPlane(bench);
  ASSERT_NE(id, 0u);
  rig.document = *bench.snapshot()->document;
  const size_t before = bench.snapshot()->done;
  const Vec3d tip = rig.handle("along normal").points[1];
  rig.drag(rig.at(tip), rig.at(tip + Vec3d(0, 0, 25)), 100);
  EXPECT_GT(rig.edits, 60);
  ASSERT_TRUE(settle(bench));
  EXPECT_EQ(bench.snapshot()->done, before + 1);
  EXPECT_NEAR(bench.snapshot()->document->guide(id)->pose.translation.z(), 25, 1e-6);

  rig.timeS += 10;
  rig.drag(rig.at(tip + Vec3d(0, 0, 25)), rig.at(tip + Vec3d(0, 0, 40)), 100);
  ASSERT_TRUE(settle(bench));
  EXPECT_EQ(bench.snapshot()->done, before + 2) << "the next drag is a step of its own";
  bench.undo();
  ASSERT_TRUE(settle(bench));
  EXPECT_NEAR(bench.snapshot()->document->guide(id)->pose.translation.z(), 25, 1e-6);
  bench.undo();
  ASSERT_TRUE(settle(bench));
  EXPECT_NEAR(bench.snapshot()->document->guide(id)->pose.translation.z(), 0, 1e-9);
}

TEST(Widgets, WorkInTheStudiosOwnContext) {
  if (render::devices().empty()) GTEST_SKIP() << "no Vulkan driver on this machine: there is no renderer to ask";
  engine::Workbench bench(quiet());
  const render::Renderer renderer;
  Camera camera;
  StudioState state;
  Widgets widgets;
  render::Overlays overlays;
  auto now = bench.snapshot();
  double timeS = 0;
  const auto with = [&](auto act) {
    now = bench.snapshot();
    timeS += 0.01;
    Context context{
        .bench = bench, .now = *now, .state = state, .camera = camera, .renderer = renderer, .timeS = timeS};
    return act(context);
  };
  const auto hand = [&](float x, float y, bool down) {
    return with([&](Context& context) {
      const Camera::Ray ray = camera.ray(x, y, context.width, context.height);
      return widgets.handle(context, {.origin = ray.origin, .direction = ray.direction, .down = down});
    });
  };
  state.showWorkspaceBox = true;
  with([&](Context& context) { widgets.place(context, "plane"); });
  EXPECT_TRUE(widgets.placing());
  EXPECT_TRUE(hand(640, 360, false));
  hand(640, 360, true);
  hand(640, 360, false);
  ASSERT_TRUE(settle(bench));
  ASSERT_EQ(bench.snapshot()->document->guides.size(), 1u);
  EXPECT_FALSE(hand(4, 4, false));
  EXPECT_EQ(state.selected, bench.snapshot()->document->guides[0].id) << "what was placed is in hand";
  with([&](Context& context) {
    widgets.draw(context, overlays);
    EXPECT_TRUE(widgets.labels(context).empty()) << "a mouse has no reach";
  });
  EXPECT_GT(overlays.fills.size(), 5u);
  EXPECT_GT(overlays.polylines.size(), 5u);
  with([&](Context& context) { widgets.escape(context); });
  EXPECT_EQ(state.selected, 0u);
}

}  // namespace
}  // namespace argil::studio
