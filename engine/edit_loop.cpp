#include "engine/edit_loop.h"

#include <algorithm>
#include <span>
#include <utility>

#include "haptics/clock.h"
#include "engine/tool_table.h"

namespace argil::engine {
namespace {

constexpr size_t kBatch = 256;             // samples taken at a time
constexpr int64_t kTurnNs = 2'000'000;     // at most 500 versions a second

int64_t nanoseconds(double seconds) { return static_cast<int64_t>(seconds * 1e9); }

}  // namespace

EditLoop::EditLoop(Session& session, haptics::Scene scene, Publish publish, Options options)
    : session_(session), scene_(std::move(scene)), publish_(std::move(publish)), options_(std::move(options)), strokes_(session), batch_(kBatch) {
  // Zero stays free: a sample of a scene from before the first setTool() belongs to no tool.
  scene_.tool.id = 0;
}

void EditLoop::setTool(const Tool& tool) {
  strokes_.setTool(scene_.tool.id + 1, tool);
  ++scene_.tool.id;
  scene_.tool.radiusMm = tool.radiusMm;
  scene_.tool.work = rowOf(tool).work;
  changed_ = true;
}

void EditLoop::setCutting(bool on) {
  changed_ = changed_ || cutting_ != on;
  cutting_ = on;
}

void EditLoop::setWorkspace(const haptics::Workspace& workspace) {
  workspace.check();
  scene_.workspace = workspace;
  changed_ = true;
}

void EditLoop::setQuality(const haptics::Quality& quality) {
  haptics::Scene probe;
  probe.quality = quality;
  probe.check();
  scene_.quality = quality;
  changed_ = true;
}

bool EditLoop::turn(haptics::SampleRing& ring) {
  const int64_t begin = haptics::nowNs();
  double oldestS = 0;
  uint64_t oldest = UINT64_MAX;
  bool cutting = false;
  for (size_t count = ring.pop(batch_); count > 0; count = ring.pop(batch_)) {
    zeroNs_ = std::min(zeroNs_, haptics::nowNs() - nanoseconds(batch_[count - 1].timeS));
    for (const haptics::StylusSample& sample : std::span(batch_).first(count)) {
      if (options_.onSample) options_.onSample(sample);
      strokes_.take(sample);
      if ((sample.flags & haptics::kCutting) == 0) continue;
      cutsBefore_ = sample.index + 1;
      if (std::exchange(cutting, true)) continue;
      oldestS = sample.timeS;
      oldest = sample.index;
    }
  }
  const int64_t oldestNs = !cutting ? 0 : options_.paced ? zeroNs_ + nanoseconds(oldestS) : begin;
  const bool published = publish(oldest, oldestNs);
  if (cutting && published && options_.latency) options_.latency->add(haptics::nowNs() - oldestNs);
  return published;
}

bool EditLoop::publish(uint64_t oldest, int64_t oldestNs) {
  if (session_.inStroke()) session_.publish();
  const DocumentPtr now = session_.document();
  // A scene is due too when the clay shows more cuts without having changed: the servo waits to hear it.
  const uint64_t applied = strokes_.samplesApplied();
  const bool awaited = applied != scene_.samplesApplied && scene_.samplesApplied < cutsBefore_;
  const bool different = now != shown_;
  if (!different && !changed_ && !awaited) return false;
  scene_.samplesApplied = applied;
  if (different) scene_.editedFrom = oldest;
  auto scene = std::make_unique<haptics::Scene>(sceneOf(*now, scene_));
  if (!cutting_) scene->tool.work.reset();
  shown_ = now;
  changed_ = false;
  ++versions_;
  publish_(std::move(scene));
  if (different && options_.onDocument) options_.onDocument(now, oldestNs);
  return true;
}

void EditLoop::finish() {
  strokes_.finish();
  publish(UINT64_MAX, 0);
}

EditThread::EditThread(EditLoop& loop, haptics::SampleRing& ring) : thread_([this, &loop, &ring] { run(loop, ring); }) {}

EditThread::~EditThread() {
  stop_.store(true);
  if (thread_.joinable()) thread_.join();
}

void EditThread::stop() {
  stop_.store(true);
  if (thread_.joinable()) thread_.join();
  if (failure_) std::rethrow_exception(failure_);
}

void EditThread::run(EditLoop& loop, haptics::SampleRing& ring) {
  try {
    int64_t next = haptics::nowNs();
    while (!stop_.load()) {
      loop.turn(ring);
      // After a long turn the next one begins at once, and time is not caught up.
      next = std::max(next + kTurnNs, haptics::nowNs());
      haptics::sleepUntilNs(next);
    }
    loop.turn(ring);
    loop.finish();
  } catch (...) {
    failure_ = std::current_exception();
    failed_.store(true);
  }
}

}  // namespace argil::engine
