#include "engine/session/feel.h"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <memory>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "clay/surface/surface.h"
#include "engine/text/lay.h"
#include "haptics/base/clock.h"
#include "haptics/base/histogram.h"
#include "haptics/contact/contact.h"
#include "haptics/devices/sheets.h"
#include "haptics/devices/simulated.h"
#include "haptics/servo/servo_tick.h"

namespace argil::engine {
namespace {

using haptics::HandPath;
using haptics::HandPoint;

constexpr double kDampingFraction = 0.5;  // Of the sheet's top damping, as the servo does.
constexpr double kTravelMms = 100;        // Between parts of a path that was laid.
constexpr double kMinTravelS = 0.3;
constexpr uint64_t kTicksAStep = 1024;  // Between two looks at the job.

void tellJob(Job* job, uint64_t tick, uint64_t ticks) {
  if (job && tick % kTicksAStep == 0) job->step(double(tick) / double(ticks));
}

// The hand on the path itself, the contact alone.
void followPath(const haptics::Scene& scene, const HandPath& path, const FeelOptions& options, uint64_t ticks,
                FeelRun& run, haptics::Histogram& compute) {
  const haptics::DeviceSheet& sheet = haptics::deviceSheet(options.device);
  const auto contact = haptics::makeContact(options.contact);
  haptics::Contact::Input in;
  in.periodS = 1 / options.rateHz;
  in.topStiffnessNmm = sheet.topStiffnessNmm;
  in.dampingNsmm = kDampingFraction * sheet.topDampingNsmm;
  in.peakForceN = sheet.peakForceN;
  size_t hint = 0;
  for (uint64_t i = 0; i < ticks; ++i) {
    tellJob(options.job, i, ticks);
    FeelTick tick;
    tick.timeS = double(i) / options.rateHz;
    const HandPoint point = path.at(tick.timeS, hint);
    in.velocity = i ? Vec3d((point.position - in.hand) * options.rateHz) : Vec3d::Zero();
    in.hand = tick.hand = point.position;
    in.buttons = point.buttons;
    in.sampleIndex = i;
    const int64_t begin = haptics::nowNs();
    const haptics::Contact::Output out = contact->tick(scene, in);
    const int64_t took = haptics::nowNs() - begin;
    compute.add(took);
    tick.proxy = out.proxy;
    tick.force = out.force;
    tick.depthMm = out.depthMm;
    tick.planes = out.planes;
    tick.flags = out.flags;
    tick.computeUs = double(took) * 1e-3;
    run.ticks.push_back(tick);
  }
}

// Hand, device and servo in closed loop.
void holdDevice(const haptics::Scene& scene, const HandPath& path, const FeelOptions& options, uint64_t ticks,
                FeelRun& run, haptics::Histogram& compute) {
  haptics::SimulatedDevice device(haptics::deviceSheet(options.device), path);
  haptics::Published<haptics::Scene> published;
  published.publish(std::make_unique<const haptics::Scene>(scene));
  haptics::SampleRing ring(2);
  haptics::ServoTick servo(device, published, ring, 1 / options.rateHz, options.contact);
  for (uint64_t i = 0; i < ticks; ++i) {
    tellJob(options.job, i, ticks);
    FeelTick tick;
    tick.timeS = double(i) / options.rateHz;
    const int64_t begin = haptics::nowNs();
    const uint32_t flags = servo.run(tick.timeS, false);
    const int64_t took = haptics::nowNs() - begin;
    compute.add(took);
    const haptics::StylusSample& sample = servo.last();
    tick.hand = sample.device.translation;
    tick.proxy = sample.proxy;
    tick.force = sample.forceN;
    tick.depthMm = sample.depthMm;
    tick.planes = static_cast<int>(sample.planes);
    tick.flags = flags & ~uint32_t{haptics::kQueueFull};  // Nobody asked for samples.
    tick.computeUs = double(took) * 1e-3;
    run.ticks.push_back(tick);
  }
  if (servo.safety().fault() != haptics::Fault::none) run.summary.fault = haptics::sentence(servo.safety().fault());
  servo.park(double(ticks) / options.rateHz);
}

void summarize(FeelRun& run, const haptics::Histogram& compute) {
  FeelSummary& s = run.summary;
  s.ticks = run.ticks.size();
  s.compute = Timing::of(compute);
  std::vector<double> jumps;
  double sum2 = 0;
  for (size_t i = 0; i < run.ticks.size(); ++i) {
    const FeelTick& tick = run.ticks[i];
    s.touching += (tick.flags & haptics::kTouching) != 0;
    s.incomplete += (tick.flags & haptics::kIncomplete) != 0;
    s.clamped += (tick.flags & haptics::kClamped) != 0;
    s.peakN = std::max(s.peakN, tick.force.norm());
    s.deepestMm = std::max(s.deepestMm, tick.depthMm);
    if (!i || !(tick.flags & run.ticks[i - 1].flags & haptics::kTouching)) continue;
    jumps.push_back((tick.force - run.ticks[i - 1].force).norm());
    sum2 += jumps.back() * jumps.back();
  }
  if (jumps.empty() || !(s.peakN > 0)) return;
  std::sort(jumps.begin(), jumps.end());
  const double percent = 100 / s.peakN;
  const auto quantile = [&](double q) {
    return percent * jumps[std::min(jumps.size() - 1, static_cast<size_t>(q * double(jumps.size())))];
  };
  s.jumpP50 = quantile(0.5);
  s.jumpP99 = quantile(0.99);
  s.jumpMax = quantile(1);
  s.jumpRms = percent * std::sqrt(sum2 / double(jumps.size()));
}

}  // namespace

FeelRun feel(const haptics::Scene& scene, const HandPath& path, const FeelOptions& options) {
  scene.check();
  if (!(options.rateHz >= 100 && options.rateHz <= 8000)) throw Error("the rate must be 100 to 8000 Hz");
  if (path.empty()) throw Error("the hand path holds no points");
  if (path.durationS() > kLongestFeelS || path.points().front().timeS < 0)
    throw Error(fmt::format("the hand path runs from {:g} to {:g} s: it must lie between 0 and {:g} s",
                            path.points().front().timeS, path.durationS(), kLongestFeelS));
  const auto ticks = static_cast<uint64_t>(std::floor(path.durationS() * options.rateHz)) + 1;
  FeelRun run;
  run.ticks.reserve(ticks);
  haptics::Histogram compute;
  (options.freeHand ? holdDevice : followPath)(scene, path, options, ticks, run, compute);
  summarize(run, compute);
  return run;
}

std::string feelCsv(const FeelRun& run) {
  std::string text =
      "t_s,x_mm,y_mm,z_mm,fx_n,fy_n,fz_n,proxy_x_mm,proxy_y_mm,proxy_z_mm,planes,depth_mm,flags,compute_us\n";
  text.reserve(run.ticks.size() * 140);
  auto out = std::back_inserter(text);
  for (const FeelTick& t : run.ticks)
    fmt::format_to(out, "{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{:.6f},{},{:.6f},{},{:.2f}\n",
                   t.timeS, t.hand.x(), t.hand.y(), t.hand.z(), t.force.x(), t.force.y(), t.force.z(), t.proxy.x(),
                   t.proxy.y(), t.proxy.z(), t.planes, t.depthMm, t.flags, t.computeUs);
  return text;
}

HandPath placePath(const HandPath& path, const clay::Version& version, double radiusMm,
                   const PathPlacement& placement) {
  std::vector<HandPoint> points = path.points();
  if (placement.fit) {
    Eigen::AlignedBox3d clayBox, pathBox;
    clay::Surface surface;
    surface.update(version, 2);
    for (const Vec3d& p : surface.toMesh().positions) clayBox.extend(p);
    for (const HandPoint& p : points) pathBox.extend(p.position);
    if (clayBox.isEmpty()) throw Error("the path cannot be fitted: there is no clay");
    const double scale = (clayBox.sizes().array() / pathBox.sizes().array().max(1e-9)).minCoeff();
    // What is laid onto the clay comes from outside.
    Vec3d centre = clayBox.center();
    if (placement.onto) centre -= placement.onto->normalized() * (clayBox.diagonal().norm() + radiusMm);
    for (HandPoint& p : points) p.position = centre + std::min(1.0, scale) * (p.position - pathBox.center());
  }
  for (HandPoint& p : points) p.position += placement.moveMm;
  if (!placement.onto) return HandPath(std::move(points));

  ScriptStroke stroke;
  stroke.tool.radiusMm = radiusMm;
  stroke.onto = Onto{*placement.onto, placement.pressMm};
  for (const HandPoint& p : points) stroke.path.push_back({p.timeS, p.position});
  HandPath laid;
  const auto travel = [&](const Vec3d& from, const Vec3d& to) {
    laid = laid.then(HandPath::line(from, to, std::max(kMinTravelS, (to - from).norm() / kTravelMms)));
  };
  std::optional<Vec3d> at;
  for (const LaidStroke& part : lay(version, stroke)) {
    const std::vector<PathPoint>& way = part.stroke.path;
    if (at) travel(*at, part.from.value_or(way.front().mm));
    if (part.from) travel(*part.from, way.front().mm);
    std::vector<HandPoint> there;
    for (const PathPoint& p : way) {
      HandPoint point;
      point.timeS = p.timeS - way.front().timeS;
      point.position = p.mm;
      if (there.empty() || point.timeS > there.back().timeS) there.push_back(point);
    }
    laid = laid.then(HandPath(std::move(there)));
    at = way.back().mm;
    if (part.to) {
      travel(*at, *part.to);
      at = part.to;
    }
  }
  if (laid.empty()) throw Error("--onto: no point of the path meets the clay in that direction");
  return laid;
}

}  // namespace argil::engine
