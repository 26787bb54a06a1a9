// argil bench touch: what a servo tick costs, back to back and paced while clay is cut.

#include <cmath>
#include <memory>

#include <fmt/format.h>

#include "bench/bench.h"
#include "bench/models.h"
#include "clay/field/primitives.h"
#include "clay/store/store.h"
#include "engine/session/run.h"
#include "haptics/analysis/touch_bench.h"
#include "haptics/scene/texture.h"

namespace argil::bench {

namespace {

constexpr double kVoxelMm = 0.25;
constexpr uint64_t kTicks = 50000;
const Vec3d kBlock(80, 80, 40);  // mm; its top is at z = 20

BenchResult fromHistogram(const haptics::Histogram& h, std::string name) {
  BenchResult r;
  r.name = std::move(name);
  r.n = h.count();
  r.median = h.quantileUs(0.5);
  r.p99 = h.quantileUs(0.99);
  r.p999 = h.quantileUs(0.999);
  return r;
}

// Friction and a texture, as a carved wooden piece may have: nothing of contact is left out.
void roughen(haptics::Scene& scene) {
  haptics::Material& material = scene.materials[0];
  material.staticFriction = 0.3;
  material.dynamicFriction = 0.2;
  scene.textures.push_back(std::make_shared<const haptics::Texture>(haptics::Bumps{0.8, 0.02}));
  material.texture = 0;
}

void add(BenchReport& report, std::string name, const haptics::TickFigures& figures, std::string note) {
  BenchResult r = fromHistogram(figures.compute, std::move(name));
  r.note = fmt::format("{}{} of {} ticks in contact; simulated device included", note, figures.touching, figures.ticks);
  report.add(r);
}

// A ball slides over a sphere at 30 mm/s, pressed in by 1 mm, on a prescribed path: ticks in virtual time, warm.
void slide(BenchReport& report, double millions, double ballVoxels, bool rough) {
  const double radius = std::sqrt(millions * 1e6 / (24 * M_PI)) * kVoxelMm, ball = ballVoxels * kVoxelMm,
               seconds = kTicks / 1000.0;
  clay::Grid grid;
  grid.voxelMm = kVoxelMm;
  haptics::Scene scene;
  scene.pieces.push_back({clay::makeSphere(clay::Store::make(), grid, Vec3d::Zero(), radius), {}, 0});
  scene.tool.radiusMm = ball;
  if (rough) roughen(scene);
  const double turns = 30 * seconds / (2 * M_PI * radius);
  const haptics::HandPath path = haptics::glideOnBall(Vec3d::Zero(), radius, ball, std::min(1.0, ball), turns, seconds);
  add(report, fmt::format("touch/ball{:g}v{}/{:g}M", ballVoxels, rough ? "-rough" : "", millions),
      haptics::measureTicks(scene, path, kTicks),
      fmt::format("ball of {:g} voxels{}; ", ballVoxels, rough ? ", friction and texture" : ""));
}

// The same over a ball of 1.3 million triangles touched as it is.
void slideOnPart(BenchReport& report, bool rough) {
  constexpr double kRadius = 40, kBall = 3, kSeconds = kTicks / 1000.0;
  haptics::Scene scene = haptics::partScene(kRadius, 8, kBall);
  if (rough) roughen(scene);
  const haptics::HandPath path = haptics::glideOnBall(scene.parts[0].pose.translation, kRadius, kBall, 1,
                                                      30 * kSeconds / (2 * M_PI * kRadius), kSeconds);
  add(report, fmt::format("touch/ball3{}/1M-tri", rough ? "-rough" : ""), haptics::measureTicks(scene, path, kTicks),
      fmt::format("mesh part of 1.3 M triangles{}; ", rough ? ", friction and texture" : ""));
}

// Strokes pressed 2 mm into the top of a block, for about `seconds`.
engine::Script strokes(double seconds) {
  engine::Script script;
  const int count = std::max(1, static_cast<int>(std::lround(seconds / 3)));
  for (int s = 0; s < count; ++s) {
    engine::ScriptStroke stroke;
    stroke.drive = engine::Drive::hand;
    stroke.tool.id = s % 4 == 3 ? "add" : s % 4 == 2 ? "smooth" : "carve";
    stroke.tool.radiusMm = 3;
    stroke.tool.strength = 0.5f;
    // sunflower: spread evenly over the top
    const double turn = 2.399963 * s, reach = 5 + 25 * std::sqrt((s + 0.5) / count);
    const Vec3d middle(reach * std::cos(turn), reach * std::sin(turn), 0);
    for (int i = 0; i <= 50; ++i) {
      const double t = i / 50.0;
      const double depth = 2 * std::sin(M_PI * t);
      stroke.path.push_back(
          {2.5 * t, middle + Vec3d(8 * (t - 0.5), 4 * std::sin(2 * M_PI * t), 20 + 3 + 1 - 3 * depth)});
    }
    script.strokes.push_back(std::move(stroke));
  }
  return script;
}

// Hand-driven strokes in real time, edits on their own thread, a bare sleep loop beside it in the same seconds.
void paced(BenchReport& report, const std::string& suffix, const clay::Grid& grid, const Vec3d& blockMm, double seconds,
           Job* job) {
  engine::Session session(clay::makeBlock(clay::Store::make(), grid, Vec3d::Zero(), blockMm, 3));
  clay::Surface surface;
  engine::RunOptions run;
  run.live = true;
  run.job = job;
  const engine::RunReport done = engine::runScript(session, surface, strokes(seconds), run);
  const engine::ServoReport& servo = done.servo.value();
  const auto row = [&](const char* name, const engine::Timing& t, const engine::Timing* peer, std::string note) {
    BenchResult r;
    r.name = name + suffix;
    r.n = t.n;
    r.median = t.median;
    r.p99 = t.p99;
    r.p999 = t.p999;
    if (peer) {
      r.peer = peer->median;
      r.peerName = "bare sleep loop";
      note += fmt::format("bare p99 {:.1f} p99.9 {:.1f}: {:.2f}× and {:.2f}× of it", peer->p99, peer->p999,
                          t.p99 / peer->p99, t.p999 / peer->p999);
    }
    r.note = std::move(note);
    report.add(r);
  };
  row("touch/paced-compute", servo.compute, nullptr,
      fmt::format("peak force {:.2f} of {:.2f} N", servo.peakForceN, servo.forceLimitN));
  row("touch/paced-lateness", servo.lateness.value(), &servo.bareLateness.value(), "");
  row("touch/edit-to-feel", servo.editToFeel, nullptr,
      "from the oldest sample of an edit to the tick that feels the clay as it changed it; whole ticks");
  row("touch/paced-edit", done.edit, nullptr,
      fmt::format("sample to changed triangles; {} ticks, {} cutting, {} overrun, {} missed, {} dropped", servo.ticks,
                  servo.cutting, servo.overrun, servo.missed, servo.dropped));
  if (!servo.grant.empty()) report.heading(servo.grant);
}

}  // namespace

void benchTouch(BenchReport& report, const BenchOptions& options) {
  report.heading(
      "touch: a tick back to back in virtual time, pressed 1 mm into a sphere with voxels of 0.25 mm (a 3 mm ball is "
      "12 voxels)");
  for (const double millions : benchSizes(options.largest)) slide(report, millions, 12, true);
  slide(report, 0.8, 12, false);
  for (const double ball : {0.5, 1.0, 3.0, 6.0, 24.0}) slide(report, 0.8, ball, true);
  slideOnPart(report, false);
  slideOnPart(report, true);

  report.heading(fmt::format("touch: paced at 1 kHz for about {:g} s while the clay is cut, smoothed and built up",
                             options.seconds));
  paced(report, "", clay::Grid(), kBlock, options.seconds, options.job);
  // A block of the same height as wide as it takes; voxels in the band of all six sides.
  const double side = std::sqrt(options.largest * 1e6 / 12) * kVoxelMm;
  clay::Grid fine;
  fine.voxelMm = kVoxelMm;
  report.heading(fmt::format("touch: the same for 10 s on a block of {:g} M active voxels", options.largest));
  paced(report, fmt::format("/{:g}M", options.largest), fine, Vec3d(side, side, kBlock.z()), 10, options.job);
}

}  // namespace argil::bench
