// What an operation on a whole piece replaced lies in the buffers until it comes back.

#include <algorithm>
#include <set>

#include "render/surface/chunk_works.h"

namespace argil::render {

uint64_t SurfaceLayout::stampOf(Coord chunk) const {
  const Chunk* const there = chunkAt(chunk);
  return there ? there->stamp : 0;
}

SurfaceLayout::KeptChunk SurfaceLayout::takeOut(Coord coord) {
  KeptChunk out;
  out.node = chunks_.extract(coord);
  Chunk& chunk = out.node.mapped();
  if (chunk.draw != SIZE_MAX) out.draw = draws_[chunk.draw];
  chunk.draw = SIZE_MAX;
  out.quads = out.draw.levels[0].triangles / 2;
  out.age = age_;
  bricks_ -= chunk.held;
  quads_ -= out.quads;
  return out;
}

void SurfaceLayout::putBack(KeptChunk& kept) {
  bricks_ += kept.node.mapped().held;
  quads_ += kept.quads;
  chunks_.insert(std::move(kept.node));
}

// Chunks all of whose bricks a delta replaces are taken out as they are, and those that it brings back put in.
SurfaceLayout::Exchange SurfaceLayout::exchangeKept(const clay::SurfaceDelta& delta) {
  struct Group {
    Coord chunk;
    size_t begin, end = 0, replaced = 0, made = 0, same = 0;
    bool whole = false, back = false;
    std::array<uint64_t, 8> lower{};
  };
  std::vector<Group> groups;
  const Chunk *live = nullptr, *kept = nullptr;
  constexpr size_t kAhead = 8;
  for (size_t i = 0; i < delta.changed.size(); ++i) {
    if (i + kAhead < delta.changed.size()) __builtin_prefetch(delta.changed[i + kAhead].get());
    const clay::BrickMesh& mesh = *delta.changed[i];
    if (const Coord chunk = mesh.brick >> kChunkBits; groups.empty() || groups.back().chunk != chunk) {
      groups.push_back({chunk, i});
      live = chunkAt(chunk);
      const auto found = kept_.find(chunk);
      kept = found == kept_.end() ? nullptr : &found->second.node.mapped();
    }
    Group& group = groups.back();
    group.end = i + 1;
    if (kept && i + kAhead / 2 < delta.changed.size()) {
      const Coord ahead = delta.changed[i + kAhead / 2]->brick;
      if (ahead >> kChunkBits == group.chunk) __builtin_prefetch(kept->bricks[placeOf(ahead)].get());
    }
    const size_t place = placeOf(mesh.brick);
    if (live && live->bricks[place]) ++group.replaced;
    if (mesh.positions.empty() && mesh.quads.empty()) continue;
    ++group.made;
    if (kept && kept->bricks[place] && kept->bricks[place]->mesh.get() == &mesh) ++group.same;
  }
  // What is painted may come back with other paint.
  const auto painted = [&](const Chunk* chunk) {
    return chunk && ranges_->painted() &&
           std::any_of(chunk->bricks.begin(), chunk->bricks.end(), [](const auto& b) { return b && b->paint; });
  };
  // All that is asked of chunks is asked before one of them is out.
  std::set<Coord> seen;
  for (Group& group : groups) {
    live = chunkAt(group.chunk);
    const auto found = kept_.find(group.chunk);
    kept = found == kept_.end() ? nullptr : &found->second.node.mapped();
    group.whole = seen.insert(group.chunk).second && group.replaced == (live ? live->held : 0) && !painted(live);
    group.back = group.whole && group.made == group.same && group.made == (kept ? kept->held : 0);
    for (int n = 1; n < 8; ++n) group.lower[size_t(n)] = stampOf(group.chunk - Coord{n & 1, (n >> 1) & 1, n >> 2});
  }
  Exchange exchange;
  uint64_t replaced = 0;
  for (const Group& group : groups)
    if (const Chunk* chunk = group.whole ? chunkAt(group.chunk) : nullptr; chunk && chunk->draw != SIZE_MAX)
      replaced += draws_[chunk->draw].levels[0].triangles / 2;
  if (replaced > mostKept_) {
    exchange.rest = delta.changed;
    return exchange;
  }
  ++age_;
  for (const Group& group : groups) {
    if (!group.back)
      exchange.rest.insert(exchange.rest.end(), delta.changed.begin() + ptrdiff_t(group.begin),
                           delta.changed.begin() + ptrdiff_t(group.end));
    if (!group.whole) continue;
    KeptChunk out, in;
    if (chunkAt(group.chunk)) {
      out = takeOut(group.chunk);
      out.lower = group.lower;
      exchange.otherChunks = true;
    }
    if (const auto found = kept_.find(group.chunk); found != kept_.end()) {
      in = std::move(found->second);
      keptQuads_ -= in.quads;
      kept_.erase(found);
    }
    if (in.node && group.back) {
      putBack(in);
      exchange.otherChunks = true;
      exchange.back.emplace(group.chunk, std::move(in));
    } else if (in.node) {
      releaseChunk(in.node.mapped());
    }
    if (!out.node) continue;
    keptQuads_ += out.quads;
    kept_.emplace(group.chunk, std::move(out));
  }
  return exchange;
}

// Indices name vertices of lower chunks. What came back fits what it left, if that is there again; the others never
// fitted what came back.
void SurfaceLayout::rewriteAround(const Exchange& exchange, Works& works) {
  // The bricks of a chunk whose quads name vertices of the chunk that is `by` lower.
  const auto rewrite = [&](Coord coord, Coord by) {
    ChunkWork* const work = works.find(coord);
    if (!work) return;
    forEachPlace(work->chunk.drawn, [&](size_t place) {
      const Coord in = brickAt(place);
      if ((by.x == 0 || in.x == 0) && (by.y == 0 || in.y == 0) && (by.z == 0 || in.z == 0)) work->setChanged(place);
    });
  };
  for (const auto& [coord, kept] : exchange.back) {
    for (int n = 1; n < 8; ++n) {
      const Coord by{n & 1, (n >> 1) & 1, n >> 2};
      if (stampOf(coord - by) != kept.lower[size_t(n)]) rewrite(coord, by);
      if (!exchange.back.contains(coord + by)) rewrite(coord + by, by);
    }
  }
}

bool SurfaceLayout::dropKept(uint64_t most) {
  const size_t before = kept_.size();
  while (!kept_.empty() && (most == 0 || keptQuads_ > most)) {
    uint64_t oldest = UINT64_MAX;
    for (const auto& [coord, kept] : kept_) oldest = std::min(oldest, kept.age);
    std::erase_if(kept_, [&](auto& entry) {
      if (entry.second.age != oldest) return false;
      keptQuads_ -= entry.second.quads;
      releaseChunk(entry.second.node.mapped());
      return true;
    });
  }
  return kept_.size() < before;
}

}  // namespace argil::render
