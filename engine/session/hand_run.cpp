#include "engine/session/hand_run.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <utility>

#include <fmt/format.h>

#include "clay/base/error.h"
#include "haptics/devices/sheets.h"

namespace argil::engine {
namespace {

using haptics::HandPath;
using haptics::HandPoint;

constexpr uint32_t kButton = 1;
constexpr double kRestS = 0.1;           // the hand waits before it presses and after it has released
constexpr double kTravelMms = 150;       // between strokes, at the device
constexpr double kMinTravelS = 0.3;      // long enough for another tool to have reached the servo
constexpr double kReleaseS = 1e-3;       // a tick after the last point of a stroke
constexpr double kTimeStepS = 1e-6;      // hand paths need times that increase
constexpr double kWorkspaceShare = 0.9;  // of the device's reach that a script is fitted into
constexpr double kVirtualTurnS = 0.002;  // as the edit thread's own pace
constexpr auto kLook = std::chrono::milliseconds(10);

void append(std::vector<HandPoint>& points, double timeS, const Vec3d& device, uint32_t buttons) {
  HandPoint point;
  point.timeS = points.empty() ? timeS : std::max(timeS, points.back().timeS + kTimeStepS);
  point.position = device;
  point.buttons = buttons;
  point.pressure = buttons ? 1.0f : 0.0f;
  points.push_back(point);
}

}  // namespace

HandRun::Plan HandRun::plan(const std::vector<LaidStroke>& strokes, const haptics::DeviceSheet& sheet) {
  Plan plan;
  Eigen::AlignedBox3d box;
  for (const LaidStroke& laid : strokes) {
    for (const PathPoint& point : laid.stroke.path) box.extend(point.mm);
    if (laid.from) box.extend(*laid.from);
    if (laid.to) box.extend(*laid.to);
  }
  if (!box.isEmpty()) {
    plan.workspace.pose.translation = box.center();
    plan.workspace.scale =
        std::max(1.0, (box.sizes().array() / (kWorkspaceShare * sheet.workspaceMm.array())).maxCoeff());
  }

  std::vector<HandPoint> points;
  append(points, 0, Vec3d::Zero(), 0);
  const auto travel = [&](const Vec3d& mm) {
    const HandPoint from = points.back();
    const Vec3d to = plan.workspace.toDevice(mm);
    const double seconds = std::max(kMinTravelS, (to - from.position).norm() / kTravelMms);
    const HandPath way = HandPath::line(from.position, to, seconds);
    for (const HandPoint& point : way.points()) append(points, from.timeS + point.timeS, point.position, 0);
  };
  for (const LaidStroke& laid : strokes) {
    const std::vector<PathPoint>& path = laid.stroke.path;
    Part part;
    part.tool = laid.stroke.tool;
    part.changeS = points.back().timeS;
    const Vec3d first = laid.from ? *laid.from : path.front().mm;
    if (points.size() == 1) {
      points.back().position = plan.workspace.toDevice(first);  // where the hand is at first
    } else {
      travel(first);
    }
    if (laid.from) travel(path.front().mm);
    const double beginS = points.back().timeS + kRestS;
    for (const PathPoint& point : path) {
      append(points, beginS + (point.timeS - path.front().timeS), plan.workspace.toDevice(point.mm), kButton);
    }
    append(points, points.back().timeS + kReleaseS, points.back().position, 0);
    append(points, points.back().timeS + kRestS, points.back().position, 0);
    if (laid.to) travel(*laid.to);
    part.endS = points.back().timeS;
    plan.parts.push_back(part);
  }
  plan.path = HandPath(std::move(points));
  return plan;
}

haptics::Scene HandRun::firstScene(const Session& session, const Plan& plan, const Script& script) {
  haptics::Scene scene;
  scene.workspace = plan.workspace;
  scene.guides = sceneGuides(script.guides);
  if (script.quality) scene.quality = script.quality->touch;
  sceneOf(*session.document(), scene).check();  // With the clay that a guide may name.
  return scene;
}

EditLoop::Options HandRun::loopOptions(haptics::Histogram& latency) {
  EditLoop::Options options;
  options.onDocument = [this](const DocumentPtr& document, int64_t) {
    const clay::SurfaceDelta delta =
        surface_.update(document->piece(document->active)->version, options_.surfaceThreads);
    if (options_.onSurface) options_.onSurface(delta);
  };
  options.onSample = [this](const haptics::StylusSample& sample) { changeTool(sample.timeS); };
  options.latency = &latency;
  options.paced = options_.live;
  // In virtual time a turn does all that waits: what is published when does not depend on the clock.
  if (options_.live) options.budgetNs = EditLoop::kTurnBudgetNs;
  return options;
}

HandRun::HandRun(Session& session, clay::Surface& surface, const std::vector<LaidStroke>& strokes, const Script& script,
                 const RunOptions& options, haptics::Histogram& latency)
    : options_(options),
      surface_(surface),
      plan_(plan(strokes, haptics::deviceSheet(options.device))),
      device_(haptics::deviceSheet(options.device), plan_.path),
      servo_(device_, scene_, {.rateHz = options.rateHz}),
      bare_(options.rateHz),
      loop_(
          session, firstScene(session, plan_, script),
          [this](std::unique_ptr<const haptics::Scene> scene) {
            if (options_.live) {
              scene_.publish(std::move(scene));
            } else {
              const auto delay = static_cast<uint64_t>(std::llround(options_.publishDelayS * options_.rateHz));
              coming_.emplace_back(tick_ + delay, std::move(scene));
            }
          },
          loopOptions(latency)) {
  changeTool(0);
}

void HandRun::changeTool(double timeS) {
  for (; tool_ < plan_.parts.size() && plan_.parts[tool_].changeS <= timeS; ++tool_)
    loop_.setTool(plan_.parts[tool_].tool);
}

void HandRun::walk(size_t count, double fromFraction, double toFraction) {
  done_ = std::min(done_ + count, plan_.parts.size());
  fromS_ = servo_.timeS();
  untilS_ = plan_.parts[done_ - 1].endS;
  fromFraction_ = fromFraction;
  toFraction_ = toFraction;
  if (options_.live) {
    walkLive();
  } else {
    walkVirtual();
  }
}

void HandRun::progress(double timeS) {
  if (!options_.job) return;
  const double share = std::clamp((timeS - fromS_) / (untilS_ - fromS_), 0.0, 1.0);
  options_.job->step(fromFraction_ + share * (toFraction_ - fromFraction_));
}

void HandRun::walkVirtual() {
  const auto turnTicks = static_cast<uint64_t>(std::max(1.0, std::round(kVirtualTurnS * options_.rateHz)));
  const auto publishDue = [this](uint64_t tick) {
    size_t due = 0;
    for (; due < coming_.size() && coming_[due].first <= tick; ++due) scene_.publish(std::move(coming_[due].second));
    coming_.erase(coming_.begin(), coming_.begin() + static_cast<std::ptrdiff_t>(due));
  };
  loop_.turn(servo_.samples());
  publishDue(UINT64_MAX);
  const auto ticks = static_cast<uint64_t>(std::ceil((untilS_ - fromS_) * options_.rateHz));
  servo_.runVirtual(ticks, [&](uint64_t index, double timeS) {
    tick_ = index;
    publishDue(index);
    if (index % turnTicks != 0) return;
    loop_.turn(servo_.samples());
    progress(timeS);
  });
  loop_.turn(servo_.samples());
  loop_.finish();
  publishDue(UINT64_MAX);
}

void HandRun::walkLive() {
  // Each walk begins as the first does, wherever in the clay the hand was when the last one ended.
  servo_.reset();
  loop_.restartClock();
  loop_.turn(servo_.samples());
  grant_ = servo_.start().sentence;
  bare_.start();
  // Left by an exception too, in this order: the servo stops, the edit thread takes what is left and ends the stroke.
  EditThread edit(loop_, servo_.samples());
  {
    struct Stop {
      HandRun& run;
      ~Stop() {
        run.servo_.stop();
        run.bare_.stop();
      }
    };
    const Stop stop{*this};
    haptics::StylusSample now;
    do {
      std::this_thread::sleep_for(kLook);
      servo_.latest().load(now);
      progress(now.timeS);
    } while (now.timeS < untilS_ && !edit.failed() && servo_.fault() == haptics::Fault::none);
  }
  edit.stop();
  if (const haptics::Fault fault = servo_.fault(); fault != haptics::Fault::none) {
    throw Error(fmt::format("the force was stopped at {:.1f} s of {:.1f} s: {}", servo_.timeS(), untilS_,
                            haptics::sentence(fault)),
                Error::Kind::work);
  }
}

ServoReport HandRun::report(const std::vector<std::unique_ptr<HandRun>>& runs) {
  ServoReport report;
  haptics::Histogram compute, editToFeel, lateness, bare;
  for (const std::unique_ptr<HandRun>& run : runs) {
    const haptics::ServoStatistics& s = run->servo_.statistics();
    report.ticks += s.ticks;
    report.cutting += s.cutting;
    report.touching += s.touching;
    report.overrun += s.overrun;
    report.missed += s.missed;
    report.dropped += run->servo_.samples().dropped();
    report.clamped += s.clamped;
    report.slewed += s.slewed;
    report.stopped += s.stopped;
    report.waiting += s.waiting;
    compute.add(s.compute);
    editToFeel.add(s.editToFeel);
    lateness.add(s.lateness);
    bare.add(run->bare_.lateness());
    report.peakForceN = std::max(report.peakForceN, double(s.peakForceN));
    report.forceLimitN = run->device_.sheet().peakForceN;
    report.grant = run->grant_;
    report.stalls += run->servo_.watchdogCuts();
    if (run->servo_.fault() != haptics::Fault::none) report.fault = haptics::sentence(run->servo_.fault());
  }
  report.compute = Timing::of(compute);
  report.editToFeel = Timing::of(editToFeel);
  if (runs.front()->options_.live) {
    report.lateness = Timing::of(lateness);
    report.bareLateness = Timing::of(bare);
  }
  return report;
}

}  // namespace argil::engine
