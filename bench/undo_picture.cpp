// The first half of argil bench undo: from undo of an operation on a whole piece to its picture.

#include <algorithm>
#include <chrono>
#include <thread>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/models.h"
#include "clay/base/error.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "clay/whole/boolean.h"
#include "engine/session/surfaces.h"
#include "render/renderer/renderer.h"

namespace argil::bench {
namespace {

using namespace clay;

constexpr int kRounds = 7;

// A document, its surface and its picture's buffers, as a workbench and a window hold them.
class Shown {
 public:
  struct Times {
    double extractedUs = 0, uploadedUs = 0;
    size_t bricks = 0;
    uint64_t bytes = 0;
  };
  explicit Shown(bool drawn) {
    if (drawn) renderer_.emplace();
  }
  // Until the surface of `version` is where pictures are drawn from.
  Times show(const Version& version) {
    document_.pieces[0].version = version;
    Times times;
    const Stopwatch watch;
    surfaces_.follow(document_, 0, 2);
    while (surfaces_.behind()) {
      std::this_thread::sleep_for(std::chrono::microseconds(200));
      if (surfaces_.arrived()) surfaces_.follow(document_, 0, 2);
    }
    const engine::SurfaceChanges changes = surfaces_.take();
    times.extractedUs = watch.us();
    for (const engine::SurfaceChange& change : changes.pieces) {
      if (!change.whole && change.delta.changed.empty()) continue;
      times.bricks += change.delta.changed.size();
      if (!renderer_) continue;
      if (change.whole) renderer_->remove(1);
      times.bytes += renderer_->update(1, change.delta).bytes;
    }
    times.uploadedUs = watch.us() - times.extractedUs;
    return times;
  }
  void begin(const Version& version) { document_ = engine::Document::of(version); }

 private:
  engine::Document document_;
  engine::Surfaces surfaces_;
  std::optional<render::Renderer> renderer_;
};

}  // namespace

void benchUndoPicture(BenchReport& report, const BenchOptions& options) {
  const bool drawn = !render::devices().empty();
  const BenchModel model = benchSphere(options.largest);
  const Version& before = model.version;
  const auto sphere = [&](const Vec3d& at, double mm) { return makeSphere(Store::make(), before.grid(), at, mm); };
  struct Step {
    const char* name;
    Version after;
  };
  const Step steps[] = {
      {"cut-of-a-quarter", combine(before, sphere({43, 5, 7}, 20), Combination::cut)},
      {"join-of-two", combine(before, sphere({30, 20, 7}, 35), Combination::join)},
  };
  report.heading(fmt::format(
      "undo of an operation on a whole piece, {:.1f} million active voxels, until its surface is "
      "where pictures are drawn from{}",
      double(before.activeVoxels()) / 1e6, drawn ? "" : " (no Vulkan driver: until it is ready to be uploaded)"));
  for (const Step& step : steps) {
    Shown shown(drawn);
    shown.begin(before);
    shown.show(before);
    const Shown::Times first = shown.show(step.after);
    Samples back[2], extracted;
    Shown::Times last;
    for (int i = 0; i < 2 * kRounds; ++i) {
      if (options.job) options.job->step(double(i) / (2 * kRounds));
      last = shown.show(i % 2 == 0 ? before : step.after);
      back[i % 2].add(last.extractedUs + last.uploadedUs);
      extracted.add(last.extractedUs);
    }
    for (const int way : {0, 1}) {
      BenchResult r =
          back[way].result(fmt::format("undo/{}-of-{}/{}", way == 0 ? "undo" : "redo", step.name, model.name));
      r.bricks = last.bricks;
      r.bytes = last.bytes;
      r.threads = 2;
      r.note =
          fmt::format("the first time {:.0f} ms, {:.0f} of them for the surface; now {:.1f} of it",
                      (first.extractedUs + first.uploadedUs) / 1e3, first.extractedUs / 1e3, extracted.median() / 1e3);
      report.add(std::move(r));
    }
  }
}

}  // namespace argil::bench
