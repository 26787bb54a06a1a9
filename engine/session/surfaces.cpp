#include "engine/session/surfaces.h"

#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
#include <unordered_set>
#include <utility>

#include "clay/store/unshared.h"
#include "clay/surface/vertex_channels.h"
#include "engine/document/jobs.h"

namespace argil::engine {
namespace {

constexpr size_t kMostDeltas = 64;  // of a piece that wait unmerged: beyond, nobody is taking them

uint64_t key(Coord c) {
  const auto bits = [](int32_t v) { return static_cast<uint64_t>(static_cast<uint32_t>(v)) & 0x1fffff; };
  return bits(c.x) << 42 | bits(c.y) << 21 | bits(c.z);
}

}  // namespace

clay::SurfaceDelta Surfaces::merge(std::vector<clay::SurfaceDelta>& deltas) {
  if (deltas.size() == 1) return std::move(deltas.front());
  clay::SurfaceDelta merged;
  merged.grid = deltas.back().grid;
  std::unordered_map<uint64_t, size_t> place, paintPlace;
  for (clay::SurfaceDelta& delta : deltas) {
    for (clay::BrickMeshPtr& mesh : delta.changed) {
      const auto [at, fresh] = place.try_emplace(key(mesh->brick), merged.changed.size());
      if (fresh) {
        merged.changed.push_back(std::move(mesh));
      } else {
        merged.changed[at->second] = std::move(mesh);
      }
    }
    for (auto& paint : delta.painted) {
      const auto [at, fresh] = paintPlace.try_emplace(key(paint->brick), merged.painted.size());
      if (fresh) merged.painted.emplace_back();
      merged.painted[at->second] = std::move(paint);
    }
    merged.keepsBefore |= delta.keepsBefore;
  }
  return merged;
}

clay::SurfaceDelta Surfaces::Followed::update(const clay::Version& to, int threads, bool keepBefore) {
  clay::SurfaceDelta delta = surface.update(to, threads, keepBefore);
  if (checks) checks->follow(surface, delta, threads);
  version = to;
  return delta;
}

class Surfaces::Prepared {
 public:
  Prepared(const clay::Version& version, int threads, clay::Grade asked)
      : followed(std::make_unique<Followed>(asked, std::nullopt)), grade(asked) {
    delta = followed->update(version, threads);
  }
  std::unique_ptr<Followed> followed;
  clay::Grade grade;
  clay::SurfaceDelta delta;
};

Surfaces::~Surfaces() {
  {
    const std::lock_guard lock(mutex_);
    stop_ = true;
  }
  work_.notify_one();
  if (helper_.joinable()) helper_.join();
}

void Surfaces::follow(const Document& document, int64_t oldestSampleNs, int threads) {
  std::exception_ptr failure;
  failedNow_.clear();
  const bool arrived = takeArrived(failure);
  ownNow_ = 0;
  if (document.stroke != 0 && document.stroke == seenStroke_ && !arrived && !failure) {
    ++looks_;
    followPlace(document, seenPlace_, oldestSampleNs != 0, threads, failure);
    endFollowing(oldestSampleNs, failure);
    return;
  }
  // In a stroke the same pieces are there in the same order, and all but one are as they were: that costs a look at
  // each.
  bool same = !std::exchange(forgotten_, false) && seen_.size() == document.pieces.size();
  for (size_t i = 0; same && i < seen_.size(); ++i) same = seen_[i].piece == document.pieces[i].id;
  if (!same) {
    std::unordered_set<Id> there;
    for (const Piece& piece : document.pieces) there.insert(piece.id);
    for (auto at = followed_.begin(); at != followed_.end();) {
      if (there.contains(at->first)) {
        ++at;
        continue;
      }
      letGo(std::move(at->second));
      at = followed_.erase(at);
    }
    std::vector<Id> gone;
    for (const Id id : shown_)
      if (!there.contains(id)) gone.push_back(id);
    for (const Id id : gone) deliver(id, {false, true, {}});
    seen_.assign(document.pieces.size(), {});
    for (size_t i = 0; i < seen_.size(); ++i) seen_[i].piece = document.pieces[i].id;
  }
  bool all = true;
  looks_ += seen_.size();
  for (size_t i = 0; i < seen_.size(); ++i) {
    if (document.pieces[i].id == document.active) seenPlace_ = i;
    // An address is enough: what is followed is held.
    const Piece& piece = document.pieces[i];
    if (seen_[i].record && seen_[i].record == piece.version.record() &&
        seen_[i].rotation.coeffs() == piece.pose.rotation.coeffs())
      continue;
    const bool settled = followPlace(document, i, oldestSampleNs != 0, threads, failure);
    all = all && (settled || i == seenPlace_);
  }
  seenStroke_ = all ? document.stroke : 0;
  endFollowing(oldestSampleNs, failure);
}

// Whether its surface is there, or in the helper's hands until takeArrived() says so.
bool Surfaces::followPlace(const Document& document, size_t place, bool stroke, int threads,
                           std::exception_ptr& failure) {
  const Piece& piece = document.pieces[place];
  seen_[place].record = nullptr;
  if (failedNow_.contains(piece.id)) return false;
  try {
    if (followOne(piece, stroke, threads)) seen_[place] = {piece.id, piece.version.record(), piece.pose.rotation};
    return true;
  } catch (...) {
    // Half a surface is none: it comes whole when it comes again.
    followed_.erase(piece.id);
    if (!failure) failure = std::current_exception();
    return false;
  }
}

void Surfaces::endFollowing(int64_t oldestSampleNs, const std::exception_ptr& failure) {
  {
    const std::lock_guard lock(mutex_);
    if (oldestSampleNs != 0 && (oldestNs_ == 0 || oldestSampleNs < oldestNs_)) oldestNs_ = oldestSampleNs;
  }
  if (failure) std::rethrow_exception(failure);
}

// False while its surface is in the helper's hands.
bool Surfaces::followOne(const Piece& piece, bool stroke, int threads) {
  std::unique_ptr<Followed>& followed = followed_[piece.id];
  if (followed && followed->away != 0) return false;
  const bool fresh = !followed;
  const auto turned = [&] { return followed->checks && followed->checks->turn(piece.pose.rotation); };
  if (!fresh && followed->version == piece.version && !turned()) return true;
  // Bricks of another store or grid do not replace those of the one before.
  const bool whole = fresh || !followed->version || followed->version.store() != piece.version.store() ||
                     !(followed->version.grid() == piece.version.grid());
  Waiting one{whole, false, {}};
  std::unique_ptr<Followed> old;
  if (const std::shared_ptr<Prepared> prepared = takePrepared(piece.version, whole)) {
    one.whole = true;
    old = std::exchange(followed, std::move(prepared->followed));
    one.deltas.push_back(std::move(prepared->delta));
  } else if (whole) {
    old = std::exchange(followed, nothingYet());
  }
  if (old) letGo(std::move(old));
  if (turned() || followed->version != piece.version) {
    const bool nothing = !followed->version;
    uint64_t bricks = 0;
    if (nothing) {
      bricks = piece.version.stats().bricks;
    } else if (!stroke && !followed->surface.keeps(piece.version)) {
      bricks = clay::differingLeaves(followed->version, piece.version, kMostOwnBricks);
    }
    if (ownNow_ + bricks > kMostOwnBricks) {
      if (!one.deltas.empty()) deliver(piece.id, std::move(one));
      Task task;
      task.name = nextTask_++;
      task.piece = piece.id;
      task.version = piece.version;
      task.whole = nothing;
      task.threads = threads;
      task.followed = std::exchange(followed, nothingYet());
      followed->away = task.name;
      send(std::move(task));
      return false;
    }
    ownNow_ += bricks;
    ownBricks_ += bricks;
    one.deltas.push_back(followed->update(piece.version, threads));
  }
  deliver(piece.id, std::move(one));
  return true;
}

void Surfaces::deliver(Id piece, Waiting one) {
  if (one.removed)
    shown_.erase(piece);
  else if (one.whole)  // As it always comes first.
    shown_.insert(piece);
  const std::lock_guard lock(mutex_);
  Waiting& waiting = waiting_[piece];
  if (one.whole || one.removed) {
    waiting = std::move(one);
    return;
  }
  for (clay::SurfaceDelta& delta : one.deltas) waiting.deltas.push_back(std::move(delta));
  if (waiting.deltas.size() > kMostDeltas) waiting.deltas = {merge(waiting.deltas)};
}

void Surfaces::send(Task task) {
  const std::lock_guard lock(mutex_);
  if (!helper_.joinable()) helper_ = std::thread([this] { help(); });
  tasks_.push_back(std::move(task));
  ++away_;
  work_.notify_one();
}

void Surfaces::letGo(std::unique_ptr<Followed> old) {
  if (old->surface.vertexCount() < kMostOwnBricks) return;
  Task task;
  task.old = std::move(old);
  send(std::move(task));
}

// One that was sent back by a piece that is gone or comes anew otherwise is dropped.
bool Surfaces::takeArrived(std::exception_ptr& failure) {
  if (!arrived_.exchange(false)) return false;
  std::deque<Task> done;
  {
    const std::lock_guard lock(mutex_);
    done.swap(done_);
  }
  for (Task& task : done) {
    --away_;
    const auto found = followed_.find(task.piece);
    if (found == followed_.end() || found->second->away != task.name) {
      if (task.followed) letGo(std::move(task.followed));
      continue;
    }
    if (task.failure) {
      // Not again at once: what failed for want of memory would be tried for ever.
      failedNow_.insert(task.piece);
      followed_.erase(found);
      if (!failure) failure = task.failure;
      continue;
    }
    found->second = std::move(task.followed);
    Waiting one{task.whole, false, {}};
    one.deltas.push_back(std::move(task.delta));
    deliver(task.piece, std::move(one));
  }
  return true;
}

void Surfaces::help() {
  (void)pthread_setname_np(pthread_self(), "argil-surfaces");
  (void)setpriority(PRIO_PROCESS, 0, BackgroundJob::kNice);  // the hand and the picture go first
  std::unique_lock lock(mutex_);
  for (;;) {
    work_.wait(lock, [this] { return stop_ || !tasks_.empty(); });
    if (stop_) return;
    Task task = std::move(tasks_.front());
    tasks_.pop_front();
    lock.unlock();
    task.old.reset();
    if (task.followed) {
      try {
        // Undo of a whole-piece step, and redo, are a swap of what is kept.
        task.delta = task.followed->update(task.version, task.threads, true);
      } catch (...) {
        task.failure = std::current_exception();
        task.followed.reset();
      }
    }
    lock.lock();
    if (task.piece == 0) {
      --away_;
      continue;
    }
    done_.push_back(std::move(task));
    arrived_ = true;
  }
}

void Surfaces::forget() {
  for (auto& [id, followed] : followed_) letGo(std::move(followed));
  followed_.clear();
  seen_.clear();
  forgotten_ = true;
  seenStroke_ = 0;
}

void Surfaces::setGrade(clay::Grade grade) {
  if (grade == grade_) return;
  grade_ = grade;
  forget();
}

void Surfaces::setChecks(const std::optional<CheckLimits>& limits) {
  if (limits == checks_) return;
  checks_ = limits;
  forget();
}

std::shared_ptr<Surfaces::Prepared> Surfaces::prepare(const clay::Version& version, int threads, clay::Grade grade) {
  auto one = std::make_shared<Prepared>(version, threads, grade);
  const std::lock_guard lock(mutex_);
  std::erase_if(prepared_, [](const auto& each) { return each.second.expired(); });
  prepared_.emplace(version.store().get(), one);
  return one;
}

std::shared_ptr<Surfaces::Prepared> Surfaces::takePrepared(const clay::Version& version, bool whole) {
  if (checks_) return nullptr;  // what is prepared has no walls measured
  const std::lock_guard lock(mutex_);
  const auto [begin, end] = prepared_.equal_range(version.store().get());
  auto found = end;
  std::shared_ptr<Prepared> taken;
  for (auto at = begin; at != end; ++at) {
    std::shared_ptr<Prepared> one = at->second.lock();
    if (!one || !one->followed || one->grade != grade_) continue;
    const clay::Version& has = one->followed->version;
    const bool exact = has == version;
    // One of a moment before: what changed since is little. A piece that is followed already needs none.
    if (!exact && (!whole || taken || has.store() != version.store() || !(has.grid() == version.grid()))) continue;
    taken = std::move(one);
    found = at;
    if (exact) break;
  }
  if (taken) prepared_.erase(found);
  return taken;
}

SurfaceChanges Surfaces::take() {
  std::map<Id, Waiting> taken;
  SurfaceChanges changes;
  {
    const std::lock_guard lock(mutex_);
    taken.swap(waiting_);
    changes.oldestSampleNs = std::exchange(oldestNs_, 0);
  }
  for (auto& [id, waiting] : taken) {
    SurfaceChange change{id, waiting.whole, waiting.removed, {}};
    if (!waiting.deltas.empty()) change.delta = merge(waiting.deltas);
    changes.pieces.push_back(std::move(change));
  }
  return changes;
}

}  // namespace argil::engine
