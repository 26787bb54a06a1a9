#include "engine/session/edit_loop.h"

#include <algorithm>
#include <span>
#include <utility>

#include "engine/tools/tool_table.h"
#include "haptics/base/clock.h"

namespace argil::engine {
namespace {

constexpr size_t kBatch = 256;               // samples taken at a time
constexpr size_t kFewWaiting = 1024;         // not worth coalescing
constexpr size_t kMostWaiting = 32768;       // 6 MB: beyond, samples farther apart become one too,
constexpr double kMostCoalescing = 16;       // up to 0.8 of the radius
constexpr int64_t kTurnNs = 2'000'000;       // at most 500 versions a second
constexpr uint32_t kFirstWall = 0xFFFF0000;  // guides of walls; those of documents count from 1

int64_t nanoseconds(double seconds) {
  return static_cast<int64_t>(seconds * 1e9);
}

}  // namespace

EditLoop::EditLoop(Session& session, haptics::Scene scene, Publish publish, Options options)
    : session_(session),
      scene_(std::move(scene)),
      publish_(std::move(publish)),
      options_(std::move(options)),
      strokes_(session),
      time_(options_.budgetNs),
      batch_(kBatch) {
  // Zero stays free: a sample of a scene from before the first setTool() belongs to no tool.
  scene_.tool.id = 0;
}

void EditLoop::setTool(const Tool& tool) {
  strokes_.setTool(scene_.tool.id + 1, tool);
  ++scene_.tool.id;
  scene_.tool.radiusMm = tool.radiusMm;
  scene_.tool.work = workOf(tool);
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

void EditLoop::setGuides(std::vector<haptics::Guide> guides) {
  for (const haptics::Guide& guide : guides) guide.check();
  scene_.guides = std::move(guides);
  changed_ = true;
}

void EditLoop::gather(haptics::SampleRing& ring) {
  for (size_t count = ring.pop(batch_); count > 0; count = ring.pop(batch_)) {
    zeroNs_ = std::min(zeroNs_, haptics::nowNs() - nanoseconds(batch_[count - 1].timeS));
    for (const haptics::StylusSample& sample : std::span(batch_).first(count)) {
      if (options_.onSample) options_.onSample(sample);
      waiting_.push_back({sample, false});
      if ((sample.flags & haptics::kCutting) != 0) newestCutS_ = sample.timeS;
    }
    if (const Vec3d& hand = batch_[count - 1].proxy; hand.allFinite()) handMm_ = hand;
  }
  // A ring may have lost samples before this loop was there.
  const uint64_t dropped = ring.dropped();
  if (lostBefore_ == UINT64_MAX) lostBefore_ = dropped;
  lost_ = dropped - lostBefore_;
  if (late_ && waiting_.size() > std::max(coalesceAt_, kFewWaiting) && behindS() > kCoalesceS) coalesce();
}

// One sample stands for those before it that the clay could not tell from it. The path still goes in order through all
// that is left: what is left out is shorter than half the way from stamp to stamp. Where that is not enough to bound
// memory, the distance grows.
void EditLoop::coalesce() {
  const auto cuts = [](const haptics::StylusSample& one) { return (one.flags & haptics::kCutting) != 0; };
  for (;; coalesceBy_ *= 2) {
    std::deque<Waiting> left;
    Vec3d at = Vec3d::Zero();  // of the newest in `left` that others are measured from
    bool passing = false;      // the last in `left` lies near that one: the next may take its place
    for (const Waiting& one : waiting_) {
      const haptics::StylusSample& sample = one.sample;
      haptics::StylusSample* last = left.empty() ? nullptr : &left.back().sample;
      const bool same =
          last && last->buttons == sample.buttons && last->tool == sample.tool && cuts(*last) == cuts(sample);
      if (same && !cuts(sample)) {
        *last = sample;  // the newest says for how long the tool was up
        ++coalesced_;
        continue;
      }
      const bool goesOn = same && (one.joined || sample.index == last->index + 1);
      const bool near = goesOn && (sample.cutPoint - at).norm() < coalesceBy_ * strokes_.samePlaceMm(sample.tool);
      if (goesOn && passing) {
        left.back() = {sample, true};
        ++coalesced_;
      } else {
        left.push_back(one);
      }
      passing = near;
      if (!near) at = sample.cutPoint;
    }
    waiting_.swap(left);
    if (waiting_.size() <= kMostWaiting || coalesceBy_ >= kMostCoalescing) break;
  }
  coalesceAt_ = 2 * waiting_.size();
}

bool EditLoop::turn(haptics::SampleRing& ring) {
  const int64_t begin = haptics::nowNs();
  gather(ring);
  double oldestS = inWork_.timeS;
  uint64_t oldest = inWork_.index;
  bool cutting = strokes_.more();
  int stamps = 0;
  time_.begin(begin);
  const auto spent = [&] {
    time_.step(haptics::nowNs());
    return (options_.budgetStamps > 0 && stamps >= options_.budgetStamps) || time_.over();
  };
  for (bool goOn = true; goOn;) {
    while (goOn && strokes_.more()) {
      strokes_.step();
      ++stamps;
      goOn = !spent();
    }
    if (!goOn || waiting_.empty()) break;
    const Waiting next = waiting_.front();
    waiting_.pop_front();
    inWork_ = next.sample;
    strokes_.begin(next.sample, next.joined);
    if ((next.sample.flags & haptics::kCutting) == 0) continue;
    cutsBefore_ = next.sample.index + 1;
    if (std::exchange(cutting, true)) continue;
    oldestS = next.sample.timeS;
    oldest = next.sample.index;
  }
  late_ = behind();
  if (!late_) {
    coalesceAt_ = 0;
    coalesceBy_ = 1;
  }
  if (!cutting) oldest = UINT64_MAX;
  const int64_t oldestNs = !cutting ? 0 : options_.paced ? zeroNs_ + nanoseconds(oldestS) : begin;
  const bool published = publish(oldest, oldestNs);
  if (cutting && published && options_.latency) options_.latency->add(haptics::nowNs() - oldestNs);
  return published;
}

double EditLoop::behindS() const {
  if (waiting_.empty()) return 0;
  return waiting_.back().sample.timeS - (strokes_.more() ? inWork_ : waiting_.front().sample).timeS;
}

double EditLoop::leftS() const {
  if (!behind()) return 0;
  return std::max(0.0, newestCutS_ - (strokes_.more() ? inWork_ : waiting_.front().sample).timeS);
}

// What the edit will refuse to cut the hand feels as a plane that it cannot pass: the servo knows nothing of walls, and
// would let the ball go on through clay that stays. True when they are not what they were.
bool EditLoop::lookAhead() {
  std::vector<haptics::KeepOutPlane> walls = strokes_.wallsAhead();
  const auto equal = [](const haptics::KeepOutPlane& a, const haptics::KeepOutPlane& b) {
    return a.point == b.point && a.normal == b.normal;
  };
  if (std::equal(walls.begin(), walls.end(), walls_.begin(), walls_.end(), equal)) return false;
  walls_ = std::move(walls);
  return true;
}

bool EditLoop::publish(uint64_t oldest, int64_t oldestNs) {
  if (session_.inStroke()) session_.publish();
  changed_ = lookAhead() || changed_;
  const DocumentPtr now = session_.document();
  // A scene is due too when the clay shows more cuts without having changed: the servo waits to hear it.
  const uint64_t applied = strokes_.samplesApplied();
  const bool awaited = applied != scene_.samplesApplied && scene_.samplesApplied < cutsBefore_;
  const bool different = now != shown_;
  // A hand that comes to other pieces feels them, where not all can be felt.
  if (different || felt_.visible() > haptics::kMaxPieces) changed_ = felt_.choose(*now, handMm_) || changed_;
  if (!different && !changed_ && !awaited) return false;
  scene_.samplesApplied = applied;
  if (different) scene_.editedFrom = oldest;
  auto scene = std::make_unique<haptics::Scene>(sceneOf(*now, scene_, &felt_.places()));
  if (!cutting_) scene->tool.work.reset();
  for (size_t i = 0; i < walls_.size() && scene->guides.size() < haptics::kMaxGuides; ++i)
    scene->guides.push_back({kFirstWall + static_cast<uint32_t>(i), walls_[i], scene->tool.buttons});
  shown_ = now;
  changed_ = false;
  ++versions_;
  publish_(std::move(scene));
  if (different && options_.onDocument) options_.onDocument(now, oldestNs);
  return true;
}

void EditLoop::finish() {
  while (!waiting_.empty()) {
    const Waiting next = waiting_.front();
    waiting_.pop_front();
    strokes_.begin(next.sample, next.joined);
  }
  strokes_.finish();
  publish(UINT64_MAX, 0);
}

double EditLoop::cutShort() {
  const bool held = ((waiting_.empty() ? inWork_ : waiting_.back().sample).buttons & scene_.tool.buttons) != 0;
  const auto cuts = [](const Waiting& one) { return (one.sample.flags & haptics::kCutting) != 0; };
  const auto first = std::find_if(waiting_.begin(), waiting_.end(), cuts);
  const auto last = std::find_if(waiting_.rbegin(), waiting_.rend(), cuts);
  const double seconds =
      first == waiting_.end() ? 0 : last->sample.timeS - (strokes_.more() ? inWork_ : first->sample).timeS;
  waiting_.clear();
  late_ = false;
  strokes_.cutShort(held);
  publish(UINT64_MAX, 0);
  return seconds;
}

EditThread::EditThread(EditLoop& loop, haptics::SampleRing& ring)
    : thread_([this, &loop, &ring] { run(loop, ring); }) {}

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
    loop.gather(ring);
    loop.finish();
  } catch (...) {
    failure_ = std::current_exception();
    failed_.store(true);
  }
}

}  // namespace argil::engine
