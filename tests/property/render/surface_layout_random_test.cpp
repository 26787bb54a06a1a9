// Whatever the sequence of changes, what the buffers draw is the surface.

#include <gtest/gtest.h>

#include <random>

#include "render/surface/surface_layout.h"
#include "tests/unit/render/field_surface.h"
#include "tests/unit/render/mirror_sink.h"

namespace argil::render {
namespace {

TEST(SurfaceLayoutProperty, RandomDabsDrawExactlyTheSurface) {
  constexpr unsigned kSeed = 20261120;
  std::printf("seed %u\n", kSeed);
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> place(-18, 18), size(1.5, 7);
  std::vector<std::pair<Vec3d, double>> dabs;  // radius < 0 carves
  test::FieldSurface surface;
  test::MirrorSink sink;
  BufferRanges ranges;
  SurfaceLayout layout(ranges);
  const auto field = [&](const Vec3d& p) {
    double d = p.norm() - 13;
    for (const auto& [centre, radius] : dabs) {
      const double ball = (p - centre).norm() - std::abs(radius);
      d = radius < 0 ? std::max(d, -ball) : std::min(d, ball);
    }
    return d;
  };
  uint64_t drawn = 0;
  for (int step = 0; step < 40; ++step) {
    sink.beginUpdate();
    layout.apply(surface.update({}, {-4, -4, -4}, {3, 3, 3}, field), sink);
    ASSERT_EQ(sink.drawn(layout), test::inUnits(surface.triangles())) << "seed " << kSeed << ", step " << step;
    drawn += layout.triangleCount();
    const Vec3d centre(place(random), place(random), place(random));
    const double radius = size(random);
    dabs.emplace_back(centre, step % 2 ? radius : -radius);
    if (step % 11 == 10) dabs.erase(dabs.begin(), dabs.begin() + 6);  // large parts come and go at once
  }
  EXPECT_GT(drawn, 100000u);
}

}  // namespace
}  // namespace argil::render
