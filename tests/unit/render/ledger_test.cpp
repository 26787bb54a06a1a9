// What a picture does not show costs it nothing: no call, no pass over the picture, no byte on the device.

#include <gmock/gmock.h>

#include <functional>
#include <string>
#include <vector>

#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "tests/unit/render/picture_fixture.h"

namespace argil::render {
namespace {

using test::kBare;
using testing::ElementsAreArray;

clay::SurfaceDelta ball(double radiusMm) {
  clay::Grid grid;
  clay::Surface surface;
  return surface.update(clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), radiusMm));
}

struct Cost {
  uint64_t calls = 0, bytes = 0;
  std::vector<std::string> passes;
};

// Something that a picture may hold, and the same switched off.
struct Row {
  const char* name;
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
    Cost now{renderer_->drawStats().drawCalls, renderer_->deviceBytes(), {}};
    for (const PassTime& pass : renderer_->passTimes()) now.passes.emplace_back(pass.name);
    return now;
  }

  Shot shot_;
};

TEST_F(PictureLedger, WhatIsOffCostsNothing) {
  const std::vector<Row> rows = {
      {"stereo", [](Renderer&, Shot& shot) { shot.stereo.mode = StereoMode::anaglyph; },
       [](Renderer&, Shot& shot) { shot.stereo.mode = StereoMode::mono; }},
      {"a second piece", [](Renderer& r, Shot&) { r.update(2, ball(6)); }, [](Renderer& r, Shot&) { r.remove(2); }},
      {"shadow", [](Renderer&, Shot& shot) { shot.look.keyShadow = true; },
       [](Renderer&, Shot& shot) { shot.look.keyShadow = false; }},
      {"cavity", [](Renderer&, Shot& shot) { shot.look.cavity = true; },
       [](Renderer&, Shot& shot) { shot.look.cavity = false; }},
      {"ground", [](Renderer&, Shot& shot) { shot.look.grid = true; },
       [](Renderer&, Shot& shot) { shot.look.grid = false; }},
      {"section", [](Renderer&, Shot& shot) { shot.look.section.emplace(); },
       [](Renderer&, Shot& shot) { shot.look.section.reset(); }},
      {"cursor",
       [](Renderer&, Shot& shot) {
         shot.look.cursorShadow = shot.look.beam = true;
         shot.overlays.cursor.emplace();
       },
       [](Renderer&, Shot& shot) {
         shot.look.cursorShadow = shot.look.beam = false;
         shot.overlays.cursor.reset();
       }},
      {"guides",
       [](Renderer&, Shot& shot) {
         shot.overlays.polylines.push_back({.pointsMm = {Vec3d::Zero(), {20, 0, 0}}});
       },
       [](Renderer&, Shot& shot) { shot.overlays.polylines.clear(); }},
  };
  (void)cost();
  const Cost bare = cost();
  EXPECT_EQ(bare.calls, 1u);
  for (const Row& row : rows) {
    SCOPED_TRACE(row.name);
    row.on(*renderer_, shot_);
    const Cost on = cost();
    row.off(*renderer_, shot_);
    const Cost off = cost();
    EXPECT_EQ(off.calls, bare.calls);
    EXPECT_THAT(off.passes, ElementsAreArray(bare.passes));
    EXPECT_EQ(off.bytes, bare.bytes);
    std::printf("%-15s calls %llu %llu, passes %zu %zu, bytes %llu %llu\n", row.name, (unsigned long long)on.calls,
                (unsigned long long)off.calls, on.passes.size(), off.passes.size(), (unsigned long long)on.bytes,
                (unsigned long long)off.bytes);
  }
}

}  // namespace
}  // namespace argil::render
