// Levels of detail: the indices of a chunk again, with fewer vertices.

#include <unordered_map>

#include "render/surface/chunk_works.h"

namespace argil::render {
namespace {

constexpr int kChunkEdge = 1 << kChunkBits;

/// Along which axes a brick is its chunk's last. Quads of other chunks name vertices of such bricks as they are, so
/// their outer layer stays: no crack opens between chunks, whatever level each is drawn at.
unsigned lastAlong(Coord brick) {
  constexpr int last = kChunkEdge - 1;
  return unsigned((brick.x & last) == last) | unsigned((brick.y & last) == last) << 1 |
         unsigned((brick.z & last) == last) << 2;
}

}  // namespace

void SurfaceLayout::dropLevels(Chunk& chunk) {
  chunk.tight.reset();
  for (size_t level = 1; level < size_t(kLevels); ++level) {
    ChunkLevel& made = chunk.levels[level];
    ranges_->releaseVertices(made.firstVertex, made.vertexCount);
    ranges_->releaseQuads(made.firstQuad, made.quadCount);
    made = {};
    if (chunk.draw != SIZE_MAX) draws_[chunk.draw].levels[level] = {};
  }
}

size_t SurfaceLayout::prepareChunk(size_t at, int level, UploadSink& sink) {
  ChunkDraw& draw = draws_[at];
  Chunk& chunk = chunks_.at(draw.chunk);
  if (!atRest(at)) return 0;
  size_t cost = 0;
  if (!draw.coned) {
    draw.cone = coneOf(chunk);
    draw.coned = true;
    cost += draw.levels[0].triangles / 2;
  }
  if (!draw.levels[size_t(level)].made) {
    makeLevel(chunk, level, sink);
    cost += draw.levels[0].triangles / 2;
  }
  return cost;
}

NormalCone SurfaceLayout::coneOf(const Chunk& chunk) const {
  ConeBuilder cone;
  const Lower lower = lowerOf(chunk);
  forEachPlace(chunk.drawn, [&](size_t place) {
    const Bases bases = basesOf(lower, place);
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
  });
  return cone.cone();
}

/// A level has vertices of its own, in the order in which its triangles name them: a device that fetched one in nine of
/// the finer ones would wait for memory most of the time.
void SurfaceLayout::makeLevel(Chunk& chunk, int level, UploadSink& sink) {
  struct Source {
    const BrickEntry* brick = nullptr;
    std::vector<uint16_t> standing;  // empty for bricks of other chunks: there each vertex stands for itself
    std::vector<uint32_t> placed;    // where a vertex is in this level, plus one
  };
  std::unordered_map<const BrickEntry*, Source> sources;
  const bool painted = ranges_->painted();
  vertexScratch_.clear();
  indexScratch_.clear();
  paintScratch_.clear();
  const Lower lower = lowerOf(chunk);
  forEachPlace(chunk.drawn, [&](size_t place) {
    const Bases bases = basesOf(lower, place);
    std::array<Source*, 8> from{};
    for (int n = 0; n < 8; ++n) {
      if (!bases[size_t(n)].brick) continue;
      Source& source = sources[bases[size_t(n)].brick];
      from[size_t(n)] = &source;
      if (source.brick) continue;
      source.brick = bases[size_t(n)].brick;
      source.placed.resize(source.brick->mesh->positions.size());
      const Coord owner = source.brick->mesh->brick;
      if (owner >> kChunkBits == chunk.coord)
        representatives(*source.brick->mesh, level, lastAlong(owner), source.standing);
    }
    // The vertex, named by its brick's place and its number there; equal for equal vertices.
    struct Corner {
      Source* source;
      uint32_t vertex;
      bool operator==(const Corner&) const = default;
    };
    const auto resolve = [&](clay::VertexRef ref) {
      Source* source = from[size_t(ref >> clay::kVertexRefBits)];
      const uint32_t vertex = ref & clay::kVertexRefIndex;
      return Corner{source, source->standing.empty() ? vertex : source->standing[vertex]};
    };
    const auto index = [&](const Corner& corner) {
      uint32_t& placed = corner.source->placed[corner.vertex];
      if (placed == 0) {
        vertexScratch_.push_back(vertexOf(*corner.source->brick->mesh, corner.vertex));
        if (painted) paintScratch_.push_back(paintOf(*corner.source->brick, corner.vertex));
        placed = uint32_t(vertexScratch_.size());
      }
      return placed - 1;
    };
    const auto triangle = [&](const Corner& a, const Corner& b, const Corner& c) {
      if (a == b || b == c || c == a) return;
      for (const Corner& corner : {a, b, c}) indexScratch_.push_back(index(corner));
    };
    for (const auto& quad : bases[0].brick->mesh->quads) {
      if (unseen(bases, quad)) continue;
      const Corner a = resolve(quad[0]), c = resolve(quad[2]);
      if (a == c) continue;  // both triangles are gone
      triangle(a, resolve(quad[1]), c);
      triangle(a, c, resolve(quad[3]));
    }
  });
  ChunkLevel& made = chunk.levels[size_t(level)];
  ChunkDraw::Range& range = draws_[chunk.draw].levels[size_t(level)];
  const auto count = uint32_t(indexScratch_.size());
  if (count == 0) {
    range.made = true;
    return;
  }
  const uint32_t quads = (count + kIndicesPerQuad - 1) / kIndicesPerQuad;
  ranges_->reserve(vertexScratch_.size(), quads, sink);
  made.vertexCount = uint32_t(vertexScratch_.size());
  made.firstVertex = ranges_->takeVertices(made.vertexCount, sink);
  made.quadCount = quads;
  made.firstQuad = ranges_->takeQuads(quads, sink);
  for (uint32_t& each : indexScratch_) each += made.firstVertex;
  range = {made.firstQuad * kIndicesPerQuad, count, count / 3, true};
  sink.writeVertices(made.firstVertex, vertexScratch_);
  if (painted) sink.writePaint(made.firstVertex, paintScratch_);
  sink.writeIndices(range.firstIndex, indexScratch_);
}

}  // namespace argil::render
