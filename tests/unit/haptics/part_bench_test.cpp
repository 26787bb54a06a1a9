// What touching a part costs: prints figures; checks only that they were measured on what they say.

#include <gtest/gtest.h>

#include <cmath>

#include "haptics/analysis/touch_bench.h"
#include "haptics/base/clock.h"
#include "haptics/scene/part_mesh.h"

namespace argil::haptics {
namespace {

TEST(PartBench, GlidesOverAMillionTriangles) {
#if defined(__SANITIZE_ADDRESS__) || defined(__SANITIZE_THREAD__)
  constexpr int kLevel = 5;
#else
  constexpr int kLevel = 8;
#endif
  constexpr double kBall = 40, kTool = 3;
  constexpr uint64_t kTicks = 20000;
  Scene scene = partScene(kBall, kLevel, kTool);
  const PartMesh& part = *scene.parts[0].mesh;
  EXPECT_EQ(part.triangleCount(), size_t{20} << (2 * kLevel));
  EXPECT_LT(double(part.bytes()), 120.0 * double(part.triangleCount()));
  std::printf("%zu triangles, %.0f bytes each\n", part.triangleCount(),
              double(part.bytes()) / double(part.triangleCount()));
  for (const double step : {0.03, 0.08, 0.2, 0.5}) {
    const Histogram h = measureNearest(part, kBall, kTool, step, 30000);
    EXPECT_EQ(h.count(), 30000u);
    std::printf("nearest, %4.2f mm a step: median %.2f, p99 %.2f, p99.9 %.2f us\n", step, h.quantileUs(0.5),
                h.quantileUs(0.99), h.quantileUs(0.999));
  }
  for (const double speed : {30.0, 80.0, 300.0})
    for (const double friction : {0.0, 0.3}) {
      scene.materials[0].staticFriction = scene.materials[0].dynamicFriction = friction;
      const double seconds = kTicks / 1000.0;
      const HandPath path =
          glideOnBall(Vec3d::Zero(), kBall, kTool, 1, speed * seconds / (2 * M_PI * (kBall + kTool)), seconds);
      const TickFigures f = measureTicks(scene, path, kTicks);
      EXPECT_GT(f.touching, kTicks - 500);
      EXPECT_GT(f.peakForceN, 0.85);
      EXPECT_LT(f.peakForceN, 1.5);
      std::printf("a tick at %3.0f mm/s, friction %.1f: median %.2f, p99 %.2f, p99.9 %.2f us\n", speed, friction,
                  f.compute.quantileUs(0.5), f.compute.quantileUs(0.99), f.compute.quantileUs(0.999));
    }
  // What the machine itself takes: interrupts hit one in a thousand of those that last long enough.
  for (const int64_t ns : {2000, 5000}) {
    Histogram h;
    for (uint64_t i = 0; i < kTicks; ++i) {
      const int64_t begin = nowNs();
      int64_t end = begin;
      while (end - begin < ns) end = nowNs();
      h.add(end - begin);
    }
    std::printf("a loop that only reads the clock: median %.2f, p99 %.2f, p99.9 %.2f us\n", h.quantileUs(0.5),
                h.quantileUs(0.99), h.quantileUs(0.999));
  }
}

}  // namespace
}  // namespace argil::haptics
