// Levels of detail: the indices of a chunk again, with fewer vertices. Made here, or on a device from what is described
// here (render/surface/level_batch.h).

#include <algorithm>
#include <numeric>

#include "render/surface/chunk_works.h"
#include "render/surface/level_batch.h"

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

/// The bricks whose vertices the triangles of a chunk name, in the order of their first vertices: its own and those one
/// lower along each axis.
class SurfaceLayout::NamedBricks {
 public:
  struct Named {
    const BrickEntry* brick;
    uint32_t first, count;  // of its vertices
    uint16_t cell;          // of 9×9×9: the chunk's own begin at 1
    uint32_t scratch = 0;   // vertices of those before it
  };

  explicit NamedBricks(const Lower& lower) : chunk_(lower[0]->coord) {
    std::array<bool, 729> named{};
    forEachPlace(lower[0]->drawn, [&](size_t place) {
      for (size_t n = 0; n < 8; ++n) named[cellOf(place, n)] = true;
    });
    for (size_t cell = 0; cell < named.size(); ++cell) {
      if (!named[cell]) continue;
      const Coord at = inChunk(cell);
      const Chunk* chunk = lower[size_t(int(at.x < 0) | int(at.y < 0) << 1 | int(at.z < 0) << 2)];
      const BrickEntry* brick = chunk ? chunk->bricks[placeOf(at)].get() : nullptr;
      if (!brick) continue;
      __builtin_prefetch(brick);
      all_.push_back({brick, 0, 0, uint16_t(cell)});
    }
    // Bricks and meshes lie anywhere: most of the time here would be waiting for one after the other.
    for (const Named& each : all_) __builtin_prefetch(&each.brick->mesh->positions);
    for (Named& each : all_) {
      each.first = each.brick->firstVertex;
      each.count = uint32_t(each.brick->mesh->positions.size());
    }
    std::erase_if(all_, [](const Named& each) { return each.count == 0; });
    std::sort(all_.begin(), all_.end(), [](const Named& a, const Named& b) { return a.first < b.first; });
    for (Named& each : all_) {
      scratch_[each.cell] = each.scratch = vertices_;
      vertices_ += each.count;
    }
  }

  [[nodiscard]] const std::vector<Named>& all() const { return all_; }
  [[nodiscard]] uint32_t vertices() const { return vertices_; }
  /// Where the vertices begin of the brick that is lower by `n` than the one at `place`.
  [[nodiscard]] uint32_t scratchOf(size_t place, size_t n) const { return scratch_[cellOf(place, n)]; }
  [[nodiscard]] static bool own(const Named& named) {
    const Coord at = inChunk(named.cell);
    return std::min({at.x, at.y, at.z}) >= 0;
  }
  [[nodiscard]] Coord coord(const Named& named) const { return chunk_ * kChunkEdge + inChunk(named.cell); }

 private:
  static size_t cellOf(size_t place, size_t n) {
    const Coord at = brickAt(place) + Coord{1, 1, 1} - Coord{int(n & 1), int((n >> 1) & 1), int(n >> 2)};
    return size_t((at.x * 9 + at.y) * 9 + at.z);
  }
  static Coord inChunk(size_t cell) {
    const auto at = int32_t(cell);
    return Coord{at / 81, at / 9 % 9, at % 9} - Coord{1, 1, 1};
  }

  Coord chunk_;
  std::array<uint32_t, 729> scratch_{};
  std::vector<Named> all_;
  uint32_t vertices_ = 0;
};

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

size_t SurfaceLayout::describeLevel(size_t at, int level, LevelBatch& batch) const {
  const ChunkDraw& draw = draws_[at];
  const NamedBricks named(lowerOf(chunks_.at(draw.chunk)));
  LevelChunk chunk;
  chunk.firstBrick = uint32_t(batch.bricks.size());
  chunk.bricks = uint32_t(named.all().size());
  chunk.firstIndex = draw.levels[0].firstIndex;
  chunk.indices = draw.levels[0].indexCount;
  chunk.firstScratch = batch.scratch;
  chunk.scratch = named.vertices();
  for (const NamedBricks::Named& each : named.all()) {
    const Coord coord = named.coord(each);
    LevelBrick& brick = batch.bricks.emplace_back();
    brick.first = each.first;
    brick.count = each.count;
    brick.scratch = batch.scratch + each.scratch;
    if (level > 0 && NamedBricks::own(each))
      brick.flags = lastAlong(coord) | LevelBrick::kOwn | uint32_t(kGroupCells[size_t(level)]) << 4;
    // As vertices are counted: at the end of the reach both wrap.
    const auto units = [](int32_t c) { return int32_t(uint32_t(c) * uint32_t(clay::kBrickEdge * kUnitsPerVoxel)); };
    brick.zero = {units(coord.x), units(coord.y), units(coord.z), 0};
  }
  batch.scratch += named.vertices();
  batch.chunks.push_back(chunk);
  return draw.levels[0].triangles / 2;
}

void SurfaceLayout::takeLevel(size_t at, int level, const LevelSize& size, LevelChunk& chunk, UploadSink& sink) {
  ChunkDraw& draw = draws_[at];
  if (!draw.coned) draw.cone = {Vec3f(size.axis[0], size.axis[1], size.axis[2]), size.cosine - kConeSlack};
  draw.coned = true;
  if (draw.levels[size_t(level)].made || size.triangles == 0) {
    draw.levels[size_t(level)].made = true;
    chunk.indices = chunk.scratch = 0;  // nothing is left to be written
    return;
  }
  const ChunkLevel& made = placeLevel(chunks_.at(draw.chunk), level, size.vertices, size.triangles, sink);
  chunk.outVertex = made.firstVertex;
  chunk.outIndex = made.firstQuad * kIndicesPerQuad;
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

const SurfaceLayout::ChunkLevel& SurfaceLayout::placeLevel(Chunk& chunk, int level, uint32_t vertices,
                                                           uint32_t triangles, UploadSink& sink) {
  const uint32_t quads = (triangles + 1) / 2;
  ranges_->reserve(vertices, quads, sink);
  ChunkLevel& made = chunk.levels[size_t(level)];
  made.firstVertex = ranges_->takeVertices(vertices, sink);
  made.vertexCount = vertices;
  made.firstQuad = ranges_->takeQuads(quads, sink);
  made.quadCount = quads;
  draws_[chunk.draw].levels[size_t(level)] = {made.firstQuad * kIndicesPerQuad, 3 * triangles, triangles, true};
  return made;
}

/// A level has vertices of its own, in the order of the finer ones: a device that fetched one in nine of those would
/// wait for memory most of the time. Triangles come in the order of their chunk's block.
void SurfaceLayout::makeLevel(Chunk& chunk, int level, UploadSink& sink) {
  const Lower lower = lowerOf(chunk);
  const NamedBricks named(lower);
  std::vector<uint32_t> standing(named.vertices()), placed(named.vertices());  // a vertex' place in the level, plus one
  std::vector<uint16_t> within;
  for (const NamedBricks::Named& each : named.all()) {
    const clay::BrickMesh& mesh = *each.brick->mesh;
    const auto begin = standing.begin() + each.scratch;
    std::iota(begin, begin + long(mesh.positions.size()), each.scratch);
    if (!NamedBricks::own(each)) continue;  // of other chunks each vertex stands for itself
    representatives(mesh, level, lastAlong(mesh.brick), within);
    for (size_t i = 0; i < within.size(); ++i) standing[each.scratch + i] = each.scratch + within[i];
  }
  std::vector<size_t> places;
  forEachPlace(chunk.drawn, [&](size_t place) { places.push_back(place); });
  std::sort(places.begin(), places.end(),
            [&](size_t a, size_t b) { return chunk.bricks[a]->firstQuad < chunk.bricks[b]->firstQuad; });
  indexScratch_.clear();
  for (const size_t place : places) {
    const Bases bases = basesOf(lower, place);
    std::array<uint32_t, 8> from{};
    for (size_t n = 0; n < bases.size(); ++n)
      if (bases[n].count > 0) from[n] = named.scratchOf(place, n);
    const auto resolve = [&](clay::VertexRef ref) {
      return standing[from[size_t(ref >> clay::kVertexRefBits)] + (ref & clay::kVertexRefIndex)];
    };
    const auto triangle = [&](uint32_t a, uint32_t b, uint32_t c) {
      if (a == b || b == c || c == a) return;
      for (const uint32_t corner : {a, b, c}) {
        indexScratch_.push_back(corner);
        placed[corner] = 1;
      }
    };
    for (const auto& quad : bases[0].brick->mesh->quads) {
      if (unseen(bases, quad)) continue;
      const uint32_t a = resolve(quad[0]), c = resolve(quad[2]);
      if (a == c) continue;  // both triangles are gone
      triangle(a, resolve(quad[1]), c);
      triangle(a, c, resolve(quad[3]));
    }
  }
  if (indexScratch_.empty()) {
    draws_[chunk.draw].levels[size_t(level)].made = true;
    return;
  }
  const bool painted = ranges_->painted();
  vertexScratch_.clear();
  paintScratch_.clear();
  for (const NamedBricks::Named& each : named.all()) {
    for (size_t i = 0; i < each.brick->mesh->positions.size(); ++i) {
      uint32_t& place = placed[each.scratch + i];
      if (place == 0) continue;
      vertexScratch_.push_back(vertexOf(*each.brick->mesh, i));
      if (painted) paintScratch_.push_back(paintOf(*each.brick, i));
      place = uint32_t(vertexScratch_.size());
    }
  }
  const ChunkLevel& made =
      placeLevel(chunk, level, uint32_t(vertexScratch_.size()), uint32_t(indexScratch_.size() / 3), sink);
  for (uint32_t& each : indexScratch_) each = made.firstVertex + placed[each] - 1;
  sink.writeVertices(made.firstVertex, vertexScratch_);
  if (painted) sink.writePaint(made.firstVertex, paintScratch_);
  sink.writeIndices(made.firstQuad * kIndicesPerQuad, indexScratch_);
}

}  // namespace argil::render
