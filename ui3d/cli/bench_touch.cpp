// argil bench touch: what a servo tick costs, back to back and paced while clay is cut.

#include <cmath>

#include <fmt/format.h>

#include "clay/primitives.h"
#include "clay/store.h"
#include "engine/run.h"
#include "haptics/touch_bench.h"
#include "ui3d/cli/bench.h"
#include "ui3d/cli/bench_models.h"

namespace argil::cli {

namespace {

constexpr double kVoxelMm = 0.25;
constexpr uint64_t kTicks = 50000;

BenchResult fromHistogram(const haptics::Histogram& h, std::string name) {
  BenchResult r;
  r.name = std::move(name);
  r.n = h.count();
  r.median = h.quantileUs(0.5);
  r.p99 = h.quantileUs(0.99);
  r.p999 = h.quantileUs(0.999);
  return r;
}

// A ball slides over a sphere at 30 mm/s, pressed in by 1 mm, on a prescribed path: ticks in virtual time, warm.
void slide(BenchReport& report, double millions, double ballVoxels) {
  const double radius = std::sqrt(millions * 1e6 / (24 * M_PI)) * kVoxelMm, ball = ballVoxels * kVoxelMm, seconds = kTicks / 1000.0;
  clay::Grid grid;
  grid.voxelMm = kVoxelMm;
  haptics::Scene scene;
  scene.pieces.push_back({clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), radius), {}, 0});
  scene.tool.radiusMm = ball;
  const double turns = 30 * seconds / (2 * M_PI * radius);
  const haptics::HandPath path = haptics::glideOnBall(Vec3d::Zero(), radius, ball, 1, turns, seconds);
  const haptics::TickFigures figures = haptics::measureTicks(scene, path, kTicks);
  BenchResult r = fromHistogram(figures.compute, fmt::format("touch/ball{:g}v/{:g}M", ballVoxels, millions));
  r.note = fmt::format("ball of {:g} voxels; {} of {} ticks in contact; simulated device included", ballVoxels, figures.touching, figures.ticks);
  report.add(r);
}

// Strokes pressed 2 mm into the top of a block, for about `seconds`.
engine::Script strokes(double seconds) {
  engine::Script script;
  script.voxelMm = 0.5;
  script.clay = engine::BlockSetup{Vec3d(80, 80, 40), 3, Vec3d::Zero()};
  const int count = std::max(1, static_cast<int>(std::lround(seconds / 3)));
  for (int s = 0; s < count; ++s) {
    engine::ScriptStroke stroke;
    stroke.drive = engine::Drive::hand;
    stroke.tool.operation = s % 4 == 3 ? clay::Operation::add : s % 4 == 2 ? clay::Operation::smooth : clay::Operation::carve;
    stroke.tool.radiusMm = 3;
    stroke.tool.strength = 0.5f;
    const double turn = 2.399963 * s, reach = 5 + 25 * std::sqrt((s + 0.5) / count);  // sunflower: spread evenly over the top
    const Vec3d middle(reach * std::cos(turn), reach * std::sin(turn), 0);
    for (int i = 0; i <= 50; ++i) {
      const double t = i / 50.0;
      const double depth = 2 * std::sin(M_PI * t);
      stroke.path.push_back({2.5 * t, middle + Vec3d(8 * (t - 0.5), 4 * std::sin(2 * M_PI * t), 20 + 3 + 1 - 3 * depth)});
    }
    script.strokes.push_back(std::move(stroke));
  }
  return script;
}

}  // namespace

void benchTouch(BenchReport& report, const BenchOptions& options) {
  report.heading("touch: a tick back to back in virtual time, pressed 1 mm into a sphere with voxels of 0.25 mm");
  for (const double millions : benchSizes(options.largest)) slide(report, millions, 12);
  for (const double ball : {2.0, 4.0, 8.0, 24.0}) slide(report, 0.8, ball);

  report.heading(fmt::format("touch: paced at 1 kHz for about {:g} s while the clay is cut, smoothed and built up", options.seconds));
  const engine::Script script = strokes(options.seconds);
  clay::Grid grid;
  engine::Session session(clay::makeBlock(clay::Store::make(), grid, Vec3d::Zero(), Vec3d(80, 80, 40), 3));
  clay::Surface surface;
  engine::RunOptions run;
  run.live = true;
  run.job = options.job;
  const engine::RunReport done = engine::runScript(session, surface, script, run);
  const engine::ServoReport& servo = done.servo.value();
  const auto add = [&](const char* name, const engine::Timing& t, const engine::Timing* peer, std::string note) {
    BenchResult r;
    r.name = name;
    r.n = t.n;
    r.median = t.median;
    r.p99 = t.p99;
    r.p999 = t.p999;
    if (peer) {
      r.peer = peer->median;
      r.peerName = "bare sleep loop";
      note += fmt::format("bare p99 {:.1f} p99.9 {:.1f}: {:.2f}× and {:.2f}× of it", peer->p99, peer->p999, t.p99 / peer->p99, t.p999 / peer->p999);
    }
    r.note = std::move(note);
    report.add(r);
  };
  add("touch/paced-compute", servo.compute, nullptr, fmt::format("peak force {:.2f} of {:.2f} N", servo.peakForceN, servo.forceLimitN));
  add("touch/paced-lateness", servo.lateness.value(), &servo.bareLateness.value(), "");
  add("touch/paced-edit", done.edit, nullptr,
      fmt::format("sample to changed triangles; {} ticks, {} cutting, {} overrun, {} missed, {} dropped", servo.ticks, servo.cutting, servo.overrun,
                  servo.missed, servo.dropped));
  if (!servo.grant.empty()) report.heading(servo.grant);
}

}  // namespace argil::cli
