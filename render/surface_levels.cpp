// Levels of detail: the indices of a chunk again, with fewer vertices.

#include <algorithm>

#include "render/surface_layout.h"

namespace argil::render {
namespace {

constexpr int kChunkEdge = 1 << kChunkBits;

/// Along which axes a brick is its chunk's last. Quads of other chunks name vertices of such bricks as they are, so their outer layer
/// stays: no crack opens between chunks, whatever level each is drawn at.
unsigned lastAlong(Coord brick) {
  constexpr int last = kChunkEdge - 1;
  return unsigned((brick.x & last) == last) | unsigned((brick.y & last) == last) << 1 |
         unsigned((brick.z & last) == last) << 2;
}

size_t placeInChunk(Coord brick) {
  constexpr int mask = kChunkEdge - 1;
  return size_t((brick.x & mask) << 2 * kChunkBits | (brick.y & mask) << kChunkBits | (brick.z & mask));
}

}  // namespace

void SurfaceLayout::dropLevels(Chunk& chunk) {
  chunk.tight.reset();
  for (size_t level = 1; level < kLevels; ++level) {
    if (chunk.levelCapacity[level] == 0) continue;
    ranges_->releaseQuads(draws_[chunk.draw].levels[level].firstIndex / kIndicesPerQuad, chunk.levelCapacity[level]);
    chunk.levelCapacity[level] = 0;
    draws_[chunk.draw].levels[level] = {};
  }
}

size_t SurfaceLayout::prepareChunk(size_t at, int level, UploadSink& sink) {
  ChunkDraw& draw = draws_[at];
  const auto it = chunks_.find(draw.chunk);
  Chunk& chunk = it->second;
  if (!atRest(at)) return 0;
  size_t cost = 0;
  if (!draw.coned) {
    draw.cone = coneOf(chunk);
    draw.coned = true;
    cost += draw.levels[0].triangles / 2;
  }
  if (!draw.levels[size_t(level)].made) {
    makeLevel(it->first, chunk, level, sink);
    cost += draw.levels[0].triangles / 2;
  }
  return cost;
}

NormalCone SurfaceLayout::coneOf(const Chunk& chunk) const {
  ConeBuilder cone;
  for (const Coord coord : chunk.bricks) {
    const std::array<Base, 8> bases = basesOf(coord);
    const auto corner = [&](clay::VertexRef ref) -> Vec3f {
      const int n = ref >> clay::kVertexRefBits;
      return bases[size_t(n)].brick->mesh->positions[ref & clay::kVertexRefIndex] -
             float(clay::kBrickEdge) * Vec3f(float(n & 1), float((n >> 1) & 1), float(n >> 2));
    };
    for (const auto& quad : bases[0].brick->mesh->quads) {
      const Vec3f a = corner(quad[0]), b = corner(quad[1]), c = corner(quad[2]), d = corner(quad[3]);
      cone.add(a, b, c);
      cone.add(a, c, d);
    }
  }
  return cone.cone();
}

void SurfaceLayout::makeLevel(Coord coord, Chunk& chunk, int level, UploadSink& sink) {
  // What stands for the vertices of each brick of this chunk, found when first needed.
  std::array<std::vector<uint16_t>, size_t(kChunkEdge) * kChunkEdge * kChunkEdge> standing;
  indexScratch_.clear();
  for (const Coord at : chunk.bricks) {
    const std::array<Base, 8> bases = basesOf(at);
    std::array<const uint16_t*, 8> table{};
    for (int n = 0; n < 8; ++n) {
      const Coord owner = at - Coord{n & 1, (n >> 1) & 1, n >> 2};
      if (!bases[size_t(n)].brick || owner >> kChunkBits != coord) continue;
      std::vector<uint16_t>& made = standing[placeInChunk(owner)];
      if (made.empty()) representatives(*bases[size_t(n)].brick->mesh, level, lastAlong(owner), made);
      table[size_t(n)] = made.data();
    }
    const auto resolve = [&](clay::VertexRef ref) {
      const auto n = size_t(ref >> clay::kVertexRefBits), index = size_t(ref & clay::kVertexRefIndex);
      return bases[n].first + (table[n] ? table[n][index] : uint32_t(index));
    };
    for (const auto& quad : bases[0].brick->mesh->quads) {
      const uint32_t a = resolve(quad[0]), b = resolve(quad[1]), c = resolve(quad[2]), d = resolve(quad[3]);
      if (a == c) continue;  // both triangles are gone
      if (a != b && b != c) indexScratch_.insert(indexScratch_.end(), {a, b, c});
      if (c != d && d != a) indexScratch_.insert(indexScratch_.end(), {a, c, d});
    }
  }
  const auto count = uint32_t(indexScratch_.size());
  const uint32_t quads = std::max<uint32_t>(1, (count + kIndicesPerQuad - 1) / kIndicesPerQuad);
  const uint32_t first = ranges_->takeQuads(quads, sink);
  chunk.levelCapacity[size_t(level)] = quads;
  draws_[chunk.draw].levels[size_t(level)] = {first * kIndicesPerQuad, count, count / 3, true};
  if (count > 0) sink.writeIndices(first * kIndicesPerQuad, indexScratch_);
}

}  // namespace argil::render
