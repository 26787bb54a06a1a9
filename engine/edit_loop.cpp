#include "engine/edit_loop.h"

#include <algorithm>
#include <span>
#include <utility>

#include "haptics/clock.h"

namespace argil::engine {
namespace {

constexpr size_t kBatch = 256;             // samples taken at a time
constexpr int64_t kTurnNs = 2'000'000;     // at most 500 versions a second

int64_t nanoseconds(double seconds) { return static_cast<int64_t>(seconds * 1e9); }

}  // namespace

EditLoop::EditLoop(Session& session, clay::Surface& surface, haptics::Scene scene, Publish publish, Options options)
    : session_(session),
      surface_(surface),
      scene_(std::move(scene)),
      publish_(std::move(publish)),
      options_(std::move(options)),
      strokes_(session, scene_.pieces.empty() ? haptics::Pose() : scene_.pieces[0].pose),
      batch_(kBatch) {
  scene_.pieces.resize(1);
  scene_.pieces[0].version = session.version();
  // Zero stays free: a sample of a scene from before the first setTool() belongs to no tool.
  scene_.tool.id = 0;
}

void EditLoop::setTool(const Tool& tool) {
  strokes_.setTool(scene_.tool.id + 1, tool);
  ++scene_.tool.id;
  scene_.tool.radiusMm = tool.radiusMm;
  scene_.tool.operation = tool.operation;
  toolChanged_ = true;
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
  const bool published = publish(oldest);
  if (cutting && published && options_.latency) {
    options_.latency->add(haptics::nowNs() - (options_.paced ? zeroNs_ + nanoseconds(oldestS) : begin));
  }
  return published;
}

bool EditLoop::publish(uint64_t oldest) {
  const clay::Version before = scene_.pieces[0].version;
  const clay::Version now = session_.inStroke() ? session_.publish() : session_.version();
  // A scene is due too when the clay shows more cuts without having changed: the servo waits to hear it.
  const uint64_t applied = strokes_.samplesApplied();
  const bool awaited = applied != scene_.samplesApplied && scene_.samplesApplied < cutsBefore_;
  if (now == before && !toolChanged_ && !awaited) return false;
  scene_.pieces[0].version = now;
  scene_.samplesApplied = applied;
  if (now != before) scene_.editedFrom = oldest;
  toolChanged_ = false;
  ++versions_;
  publish_(std::make_unique<const haptics::Scene>(scene_));
  if (now != before) {
    const clay::SurfaceDelta delta = surface_.update(now, options_.surfaceThreads);
    if (options_.onSurface) options_.onSurface(delta);
  }
  return true;
}

void EditLoop::finish() {
  strokes_.finish();
  publish(UINT64_MAX);
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
