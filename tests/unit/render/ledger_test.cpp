// What a picture does not show costs it nothing: no call, and no byte on a device that never drew it.

#include <functional>
#include <vector>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "tests/unit/render/picture_fixture.h"

namespace argil::render {
namespace {

using test::kBare;

clay::SurfaceDelta ball(double radiusMm) {
  clay::Grid grid;
  clay::Surface surface;
  return surface.update(clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), radiusMm));
}

struct Cost {
  uint64_t calls = 0, bytes = 0;
};

// Something that a picture may hold, and the same switched off. What it takes at least while it is on: calls that draw
// clay, bytes on the device.
struct Row {
  const char* name;
  uint64_t calls, bytes;
  std::function<void(Renderer&, Shot&)> on, off;
};

class PictureLedger : public test::Picture {
 protected:
  void SetUp() override {
    Picture::SetUp();
    if (!renderer_) return;
    renderer_->update(1, ball(10));
    shot_.look = kBare;
    shot_.look.keyShadow = shot_.look.cursorShadow = shot_.look.beam = false;
    shot_.view.position = {0, -60, 20};
  }
  Cost cost() {
    (void)renderer_->render(shot_, kWidth, kHeight);
    return {renderer_->drawStats().drawCalls, renderer_->deviceBytes()};
  }

  Shot shot_;
};

TEST_F(PictureLedger, WhatIsOffCostsNothing) {
  const std::vector<Row> rows = {
      {"stereo", 0, 1000000, [](Renderer&, Shot& shot) { shot.stereo.mode = StereoMode::anaglyph; },
       [](Renderer&, Shot& shot) { shot.stereo.mode = StereoMode::mono; }},
      {"a second piece", 1, 0, [](Renderer& r, Shot&) { r.update(2, ball(6)); },
       [](Renderer& r, Shot&) { r.remove(2); }},
      // The map, less the page that stood in for it.
      {"shadow", 0, uint64_t{2048} * 2048 * 4 - 131072, [](Renderer&, Shot& shot) { shot.look.keyShadow = true; },
       [](Renderer&, Shot& shot) { shot.look.keyShadow = false; }},
      {"cavity", 0, 0, [](Renderer&, Shot& shot) { shot.look.cavity = true; },
       [](Renderer&, Shot& shot) { shot.look.cavity = false; }},
      {"ground", 0, 0, [](Renderer&, Shot& shot) { shot.look.grid = true; },
       [](Renderer&, Shot& shot) { shot.look.grid = false; }},
      {"section", 0, 0, [](Renderer&, Shot& shot) { shot.look.section.emplace(); },
       [](Renderer&, Shot& shot) { shot.look.section.reset(); }},
      {"cursor", 0, 0,
       [](Renderer&, Shot& shot) {
         shot.look.cursorShadow = shot.look.beam = true;
         shot.overlays.cursor.emplace();
       },
       [](Renderer&, Shot& shot) {
         shot.look.cursorShadow = shot.look.beam = false;
         shot.overlays.cursor.reset();
       }},
      {"guides", 0, 0,
       [](Renderer&, Shot& shot) {
         shot.overlays.polylines.emplace_back().pointsMm = {Vec3d::Zero(), {20, 0, 0}};
       },
       [](Renderer&, Shot& shot) { shot.overlays.polylines.clear(); }},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    TearDown();
    SetUp();  // a renderer that never drew any of them
    const Cost bare = cost();
    EXPECT_EQ(bare.calls, 1u);
    row.on(*renderer_, shot_);
    const Cost on = cost();
    EXPECT_GE(on.bytes, bare.bytes + row.bytes);
    EXPECT_EQ(on.calls, bare.calls + row.calls);
    row.off(*renderer_, shot_);
    const Cost off = cost();
    EXPECT_EQ(off.calls, bare.calls);
    // What it was drawn with is kept for the next time, once.
    for (int i = 0; i < 3; ++i) {
      row.on(*renderer_, shot_);
      (void)cost();
      row.off(*renderer_, shot_);
      EXPECT_EQ(cost().bytes, off.bytes);
    }
  }
}

}  // namespace
}  // namespace argil::render
