// argil bench looks: what each choice of the picture costs and how far its picture is off the one with everything at
// its dearest.

#include <fmt/format.h>

#include <cmath>
#include <string>
#include <vector>

#include "bench/bench.h"
#include "bench/models.h"
#include "clay/base/error.h"
#include "clay/brush/brush.h"
#include "clay/store/store.h"
#include "clay/surface/surface.h"
#include "render/renderer/renderer.h"

namespace argil::bench {

namespace {

using render::Image;
using render::Quality;
using render::Renderer;

constexpr int kWidth = 960, kHeight = 600;
constexpr int kPairs = 9;
constexpr int kMostSettling = 400;

struct Looks {
  std::string name;
  Quality quality;
};

std::vector<Looks> looks() {
  std::vector<Looks> all;
  const auto add = [&](std::string name, auto change) {
    Quality quality;
    change(quality);
    all.push_back({std::move(name), quality});
  };
  for (const int samples : {1, 3, 4})
    add(fmt::format("supersample={}", samples), [&](Quality& q) { q.supersample = samples; });
  add("key-shadow=off", [](Quality& q) { q.keyShadow = false; });
  for (const int pixels : {512, 1024, 4096, 8192})
    add(fmt::format("shadow-pixels={}", pixels), [&](Quality& q) { q.shadowPixels = pixels; });
  add("cavity=off", [](Quality& q) { q.cavity = false; });
  for (const double pixels : {0.0, 2.0, 4.0, 8.0})
    add(fmt::format("detail={:g}", pixels), [&](Quality& q) { q.detailPixels = pixels; });
  add("moving", [](Quality& q) { q = q.moving(); });
  return all;
}

// Levels of detail are made over several pictures.
Image settled(Renderer& renderer, const render::Shot& shot, const Quality& quality) {
  renderer.setQuality(quality);
  uint64_t before = 0;
  for (int i = 0; i < kMostSettling; ++i) {
    (void)renderer.render(shot, kWidth, kHeight);
    const Renderer::DrawStats stats = renderer.drawStats();
    if (stats.levelBytes == 0 && stats.trianglesDrawn == before) break;
    before = stats.trianglesDrawn;
  }
  return renderer.render(shot, kWidth, kHeight);
}

// RMS over all channels, in steps of 1/255.
double off(const Image& a, const Image& b) {
  double sum = 0;
  for (size_t i = 0; i < a.rgba.size(); ++i) {
    const double d = double(a.rgba[i]) - double(b.rgba[i]);
    sum += d * d;
  }
  return std::sqrt(sum / (0.75 * double(a.rgba.size())));
}

}  // namespace

void benchLooks(BenchReport& report, const BenchOptions& options) {
  if (render::devices().empty()) throw Error("looks: there is no Vulkan driver here");
  Renderer renderer;
  BenchModel model = benchSphere(std::min(options.largest, 3.0));
  const Vec3d centre = model.version.grid().toVoxel(Vec3d(3, 5, 7));
  // Something to see: grooves around it.
  clay::BrushStroke stroke(model.version, clay::Brush::of(clay::Method::carve));
  Vec3d from = centre + model.radiusVoxels * Vec3d(1, 0, 0);
  for (int i = 1; i <= 400; ++i) {
    const double t = 0.1 * i, up = std::sin(0.011 * i);
    const Vec3d to =
        centre + model.radiusVoxels * Vec3d(std::cos(t) * std::cos(up), std::sin(t) * std::cos(up), std::sin(up));
    stroke.apply({from, to, model.radiusVoxels / 14});
    from = to;
  }
  clay::Surface surface(true, clay::Grade::crisp);
  (void)renderer.update(surface.update(stroke.finish()));
  render::Shot shot;
  shot.view = render::View::named("iso", renderer.bounds(), double(kWidth) / kHeight);
  Quality dearest;
  dearest.supersample = 4;
  dearest.shadowPixels = 8192;
  dearest.detailPixels = 0;
  const Image truth = settled(renderer, shot, dearest);
  report.heading(fmt::format("{}, {} × {} pixels, off: RMS in 255ths beside everything at its dearest",
                             renderer.deviceName(), kWidth, kHeight));
  const double begins = off(settled(renderer, shot, {}), truth);
  for (const Looks& each : looks()) {
    const double error = off(settled(renderer, shot, each.quality), truth);
    Samples ratios;
    for (int i = 0; i < kPairs; ++i) {
      if (options.job) options.job->step(0);
      const auto took = [&](const Quality& quality) {
        renderer.setQuality(quality);
        (void)renderer.render(shot, kWidth, kHeight);  // images of another size are made
        const Stopwatch watch;
        (void)renderer.render(shot, kWidth, kHeight);
        return watch.us();
      };
      const double before = took({}), own = took(each.quality), after = took({});
      ratios.add(2 * own / (before + after));
    }
    BenchResult result = ratios.result("looks/" + each.name);
    result.unit = "×";
    result.note = fmt::format("of the time of a picture as it begins; off {:.2f}, as it begins {:.2f}", error, begins);
    report.add(result);
  }
}

}  // namespace argil::bench
