#include "engine/surfaces.h"

#include <algorithm>
#include <unordered_map>
#include <utility>

#include "clay/vertex_channels.h"

namespace argil::engine {
namespace {

constexpr size_t kMostPrepared = 4;
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
  }
  return merged;
}

void Surfaces::follow(const Document& document, int64_t oldestSampleNs, int threads) {
  std::vector<std::pair<Id, Waiting>> news;
  for (auto at = followed_.begin(); at != followed_.end();) {
    if (document.piece(at->first)) {
      ++at;
      continue;
    }
    news.push_back({at->first, {false, true, {}}});
    at = followed_.erase(at);
  }
  for (const Piece& piece : document.pieces) {
    auto found = followed_.find(piece.id);
    if (found != followed_.end() && found->second.version == piece.version) continue;
    // Bricks of another store or grid do not replace those of the one before.
    const bool whole = found == followed_.end() || found->second.version.store() != piece.version.store() ||
                       !(found->second.version.grid() == piece.version.grid());
    if (whole) {
      followed_.erase(piece.id);
      found = followed_.try_emplace(piece.id, grade_.load()).first;
    }
    Waiting one{whole, false, {}};
    std::optional<Prepared> prepared = whole ? takePrepared(piece.version) : std::nullopt;
    if (prepared) {
      found->second = std::move(prepared->followed);
      one.deltas.push_back(std::move(prepared->delta));
    }
    if (found->second.version != piece.version) {
      one.deltas.push_back(found->second.surface.update(piece.version, threads));
      found->second.version = piece.version;
    }
    news.emplace_back(piece.id, std::move(one));
  }
  const std::lock_guard lock(mutex_);
  for (auto& [id, one] : news) {
    Waiting& waiting = waiting_[id];
    if (one.whole || one.removed) {
      waiting = std::move(one);
      continue;
    }
    waiting.deltas.push_back(std::move(one.deltas.front()));
    if (waiting.deltas.size() > kMostDeltas) waiting.deltas = {merge(waiting.deltas)};
  }
  if (oldestSampleNs != 0 && (oldestNs_ == 0 || oldestSampleNs < oldestNs_)) oldestNs_ = oldestSampleNs;
}

void Surfaces::forget() { followed_.clear(); }

void Surfaces::setGrade(clay::Grade grade) {
  if (grade == grade_) return;
  grade_ = grade;
  forget();
}

void Surfaces::prepare(const clay::Version& version, int threads, clay::Grade grade) {
  Prepared one{Followed(grade), grade, {}};
  one.delta = one.followed.surface.update(version, threads);
  one.followed.version = version;
  const std::lock_guard lock(mutex_);
  prepared_.push_back(std::move(one));
  // A piece that never came is not kept for ever.
  if (prepared_.size() > kMostPrepared) prepared_.erase(prepared_.begin());
}

std::optional<Surfaces::Prepared> Surfaces::takePrepared(const clay::Version& version) {
  const std::lock_guard lock(mutex_);
  const auto find = [&](const auto& fits) {
    return std::find_if(prepared_.begin(), prepared_.end(), [&](const Prepared& one) { return one.grade == grade_ && fits(one.followed.version); });
  };
  auto found = find([&](const clay::Version& one) { return one == version; });
  // Of a moment before: what changed since is little.
  if (found == prepared_.end()) found = find([&](const clay::Version& one) { return one && one.store() == version.store() && one.grid() == version.grid(); });
  if (found == prepared_.end()) return std::nullopt;
  Prepared one = std::move(*found);
  prepared_.erase(found);
  return one;
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
