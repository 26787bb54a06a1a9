#include "engine/session.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "clay/error.h"

namespace argil::engine {
namespace {

// Bricks and nodes freed at a time: well below a millisecond, so that a collector on the only free core is never a stall.
constexpr size_t kCollectBatch = 1024;
constexpr auto kCollectPause = std::chrono::milliseconds(2);

}  // namespace

Collector::Collector(std::shared_ptr<clay::Store> store) : store_(std::move(store)), thread_([this] { run(); }) {}

Collector::~Collector() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  wake_.notify_one();
  thread_.join();
}

void Collector::wake() {
  {
    const std::lock_guard lock(mutex_);
    dirty_ = true;
  }
  wake_.notify_one();
}

void Collector::run() {
  std::unique_lock lock(mutex_);
  while (!stop_) {
    wake_.wait(lock, [this] { return dirty_ || stop_; });
    dirty_ = false;
    for (bool more = true; more && !stop_;) {
      lock.unlock();
      more = store_->collect(kCollectBatch);
      lock.lock();
      if (more) wake_.wait_for(lock, kCollectPause, [this] { return stop_; });
    }
  }
}

Session::Session(clay::Version first, const StrokeQuality& quality)
    : quality_(quality), newest_(std::move(first)), collector_(std::make_unique<Collector>(newest_.store())) {}

Session::~Session() = default;

clay::Version Session::version() const {
  const std::lock_guard lock(mutex_);
  return newest_;
}

void Session::setVersion(const clay::Version& version) {
  {
    const std::lock_guard lock(mutex_);
    newest_ = version;
  }
  collector_->wake();
}

void Session::requireNoStroke(const char* what) const {
  if (step_) throw Error(fmt::format("{} has to wait until the stroke has ended", what), Error::Kind::work);
}

void Session::beginStroke(const Tool& tool) {
  requireNoStroke("another stroke");
  (void)StrokePath(newest_.grid(), tool, quality_);  // throws before anything is changed
  tool_ = tool;
  lifted_ = newest_;
  step_.emplace();
  step_->before = newest_;
  pointsBefore_ = 0;
}

void Session::addPoint(double timeS, const Vec3d& mm) {
  if (!step_) throw Error("a point needs a stroke that it belongs to", Error::Kind::work);
  if (!std::isfinite(timeS)) throw Error("a point of a stroke has a time that is not finite");
  if (!path_) {
    StrokePath path(lifted_.grid(), tool_, quality_);
    path.add(mm, stamps_);
    path_ = path;
    brush_ = std::make_unique<clay::BrushStroke>(lifted_);
    step_->strokes.push_back({tool_, Drive::tip, {}});
  } else {
    path_->add(mm, stamps_);
  }
  auto& record = step_->strokes.back().path;
  // A script's times never decrease; the stamps do not depend on them.
  record.push_back({record.empty() ? timeS : std::max(timeS, record.back().timeS), mm});
  ++counts_.points;
  apply();
}

void Session::apply() {
  for (const clay::Stamp& stamp : stamps_) brush_->apply(stamp);
  counts_.stamps += stamps_.size();
  stamps_.clear();  // keeps its memory
}

void Session::liftTool() {
  if (!path_) return;
  path_->finish(stamps_);
  apply();
  pointsBefore_ += path_->covered();
  lifted_ = brush_->finish();
  const auto made = brush_->counts();
  counts_.clay.bricksMade += made.bricksMade;
  counts_.clay.nodesMade += made.nodesMade;
  brush_.reset();
  path_.reset();
}

clay::Version Session::publish() {
  if (brush_) {
    setVersion(brush_->publish());
  } else if (step_) {
    setVersion(lifted_);
  }
  return newest_;
}

clay::Version Session::endStroke() {
  if (!step_) throw Error("there is no stroke to end", Error::Kind::work);
  liftTool();
  setVersion(lifted_);
  step_->after = lifted_;
  if (step_->after != step_->before) {
    undone_.clear();
    done_.push_back(std::move(*step_));
  }
  ++counts_.strokes;
  step_.reset();
  lifted_ = {};
  collector_->wake();
  return newest_;
}

uint64_t Session::coveredPoints() const { return pointsBefore_ + (path_ ? path_->covered() : 0); }

bool Session::undo() {
  requireNoStroke("undo");
  if (done_.empty()) return false;
  undone_.push_back(std::move(done_.back()));
  done_.pop_back();
  setVersion(undone_.back().before);
  return true;
}

bool Session::redo() {
  requireNoStroke("redo");
  if (undone_.empty()) return false;
  done_.push_back(std::move(undone_.back()));
  undone_.pop_back();
  setVersion(done_.back().after);
  return true;
}

Script Session::recording() const {
  requireNoStroke("the recording");
  Script script;
  script.voxelMm = newest_.grid().voxelMm;
  for (const Step& step : done_) script.strokes.insert(script.strokes.end(), step.strokes.begin(), step.strokes.end());
  return script;
}

}  // namespace argil::engine
