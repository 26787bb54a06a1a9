// A renderer that followed strokes by deltas shows what a fresh one shows, and was sent little. Prints the figures of
// render/NOTES.md.

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstdio>

#include "clay/brush/brush.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "render/renderer/renderer.h"

namespace argil::render {
namespace {

using Clock = std::chrono::steady_clock;

double milliseconds(Clock::time_point from) {
  return std::chrono::duration<double, std::milli>(Clock::now() - from).count();
}

class SculptedPicture : public testing::Test {
 protected:
  static constexpr double kRadiusMm = 40;

  void SetUp() override {
    if (devices().empty()) GTEST_SKIP() << "no Vulkan driver on this machine: pictures cannot be drawn";
  }
  static clay::Version sphere(double voxelMm) {
    clay::Grid grid;
    grid.voxelMm = voxelMm;
    return clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), kRadiusMm);
  }
  /// A short cut at an angle around z.
  static clay::Version cut(const clay::Version& version, double angle) {
    clay::BrushStroke stroke(version, clay::Brush::of(clay::Method::carve));
    const clay::Grid& grid = version.grid();
    const auto at = [&](double a) {
      return grid.toVoxel(kRadiusMm * Vec3d(std::cos(a), std::sin(a), 0.3 * std::sin(3 * a)).normalized());
    };
    for (int i = 0; i < 8; ++i) {
      clay::Stamp stamp;
      stamp.a = at(angle + 0.02 * i);
      stamp.b = at(angle + 0.02 * (i + 1));
      stamp.radius = 2 / grid.voxelMm;
      stroke.apply(stamp);
    }
    return stroke.finish();
  }
};

TEST_F(SculptedPicture, FollowingStrokesEqualsStartingAfresh) {
  clay::Version version = sphere(0.5);
  clay::Surface surface;
  RendererOptions options;
  options.validation = true;
  Renderer following(options);
  const uint64_t whole = following.update(surface.update(version)).bytes;
  const View view = View::named("iso", following.bounds(), 1.5);
  Overlays overlays;
  overlays.cursor.emplace();
  overlays.cursor->positionMm = {20, -35, 20};
  for (int i = 0; i < 6; ++i) {
    version = cut(version, -2.4 + 0.35 * i);
    const UploadStats stats = following.update(surface.update(version));
    EXPECT_GT(stats.bytes, 0u);
    EXPECT_LT(stats.bytes, whole / 12) << "stroke " << i;
  }
  clay::Surface again;
  Renderer fresh(options);
  fresh.update(again.update(version));
  EXPECT_EQ(following.triangleCount(), fresh.triangleCount());
  EXPECT_EQ(following.render(view, overlays, 480, 320), fresh.render(view, overlays, 480, 320));
  EXPECT_EQ(following.validationMessages(), std::vector<std::string>());
  EXPECT_EQ(fresh.validationMessages(), std::vector<std::string>());
}

TEST_F(SculptedPicture, AMillionTrianglesInSeconds) {
  const clay::Version version = sphere(0.245);
  clay::Surface surface;
  const auto delta = surface.update(version);
  for (const bool fine : {true, false}) {
    RendererOptions options;
    if (!fine) options.quality = {1, false, 256};
    auto from = Clock::now();
    Renderer renderer(options);
    const double start = milliseconds(from);
    from = Clock::now();
    const UploadStats whole = renderer.update(delta);
    const double upload = milliseconds(from);
    const View view = View::named("iso", renderer.bounds(), 1280.0 / 720);
    from = Clock::now();
    (void)renderer.render(view, {}, 1280, 720);
    const double first = milliseconds(from);
    double best = 1e9;
    for (int i = 0; i < 3; ++i) {
      from = Clock::now();
      (void)renderer.render(view, {}, 1280, 720);
      best = std::min(best, milliseconds(from));
    }
    std::printf(
        "%s, %s: %.2f M triangles, start %.0f ms, upload %.0f ms for %.1f MB (%.1f MB moved), first picture %.0f ms, "
        "best of three more %.0f ms, device %.0f MB\n",
        renderer.deviceName().c_str(), fine ? "2x2 samples and key shadow" : "1 sample, no key shadow",
        double(renderer.triangleCount()) / 1e6, start, upload, double(whole.bytes) / 1e6,
        double(whole.copiedBytes) / 1e6, first, best, double(renderer.deviceBytes()) / 1e6);
    EXPECT_GT(renderer.triangleCount(), 1'000'000u);
    EXPECT_LT(best, 10'000);
    EXPECT_EQ(whole.copiedBytes, 0u) << "a first load makes each buffer once";
    if (fine) {
      from = Clock::now();
      clay::Surface changed(std::move(surface));
      const auto small = changed.update(cut(version, 0.3));
      from = Clock::now();
      const UploadStats stats = renderer.update(small);
      std::printf("a stroke that changed %zu bricks: %.3f MB of %.1f MB uploaded in %.2f ms, %llu ranges\n",
                  small.changed.size(), double(stats.bytes) / 1e6, double(whole.bytes) / 1e6, milliseconds(from),
                  static_cast<unsigned long long>(stats.writes));
      EXPECT_LT(stats.bytes, whole.bytes / 50);
    }
  }
}

}  // namespace
}  // namespace argil::render
