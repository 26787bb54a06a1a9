#include "render/surface_layout.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "clay/error.h"

namespace argil::render {
namespace {

constexpr uint32_t kIndicesPerQuad = 6;
constexpr uint32_t kMaxUnits = UINT32_MAX / kIndicesPerQuad;  ///< Indices must be countable in 32 bits.
constexpr uint32_t kFirstCapacity = 1u << 16;

/// Room for a brick that grows a little while it is sculpted: an eighth more, in steps of eight.
uint32_t withSlack(size_t count) {
  return uint32_t((count + count / 8 + 7) & ~size_t{7});
}
/// A chunk's block is repacked when it is full; a quarter more keeps that rare.
uint32_t withChunkSlack(uint64_t count) {
  return uint32_t(count + count / 4 + 64);
}

int32_t fixedPoint(int32_t voxel, float offset) {
  const double units = std::floor((double(voxel) + double(offset)) * kUnitsPerVoxel + 0.5);
  return int32_t(std::clamp(units, double(INT32_MIN), double(INT32_MAX)));
}

}  // namespace

size_t SurfaceLayout::CoordHash::operator()(Coord c) const noexcept {
  uint64_t h = uint64_t(uint32_t(c.x)) * 0x9e3779b97f4a7c15u;
  h = (h ^ (h >> 29) ^ uint32_t(c.y)) * 0xbf58476d1ce4e5b9u;
  h = (h ^ (h >> 32) ^ uint32_t(c.z)) * 0x94d049bb133111ebu;
  return size_t(h ^ (h >> 31));
}

void SurfaceLayout::clear() {
  *this = SurfaceLayout();
}

void SurfaceLayout::reserve(RangeAllocator& ranges, uint64_t end, UploadSink& sink) {
  if (end <= ranges.capacity()) return;
  const uint64_t wanted = std::max<uint64_t>({kFirstCapacity, uint64_t(ranges.capacity()) * 3 / 2, end});
  if (wanted > kMaxUnits) {
    throw Error("the surface has more triangles than the renderer can address; use larger voxels", Error::Kind::work);
  }
  ranges.grow(uint32_t(wanted));
  sink.reserve(vertexRanges_.capacity(), quadRanges_.capacity() * kIndicesPerQuad);
}

uint32_t SurfaceLayout::take(RangeAllocator& ranges, uint32_t count, UploadSink& sink) {
  if (const auto begin = ranges.allocate(count)) return *begin;
  reserve(ranges, uint64_t(ranges.end()) + count, sink);
  return *ranges.allocate(count);
}

void SurfaceLayout::apply(const clay::SurfaceDelta& delta, UploadSink& sink) {
  grid_ = delta.grid;

  // Chunks that will grow get their block at once, and the buffers their size: a first load packs each chunk and makes
  // each buffer a single time.
  std::map<Coord, int64_t> growth;
  uint64_t newVertices = 0, newQuads = 0;
  for (const clay::BrickMeshPtr& mesh : delta.changed) {
    const auto it = bricks_.find(mesh->brick);
    const int64_t before = it == bricks_.end() ? 0 : int64_t(it->second.quadCapacity);
    growth[mesh->brick >> kChunkBits] += int64_t(withSlack(mesh->quads.size())) - before;
    const uint32_t vertices = withSlack(mesh->positions.size());
    if (it == bricks_.end() || vertices > it->second.vertexCapacity) newVertices += vertices;
  }
  for (const auto& [coord, added] : growth) {
    const auto it = chunks_.find(coord);
    const int64_t used = it == chunks_.end() ? 0 : it->second.quads.used();
    const int64_t capacity = it == chunks_.end() ? 0 : it->second.quads.capacity();
    if (used + added > capacity) newQuads += withChunkSlack(uint64_t(used + added));
  }
  reserve(vertexRanges_, vertexRanges_.end() + newVertices, sink);
  reserve(quadRanges_, quadRanges_.end() + newQuads, sink);

  std::set<Coord> rewrite;
  for (const clay::BrickMeshPtr& mesh : delta.changed) {
    const Coord coord = mesh->brick;
    if (mesh->positions.empty() && mesh->quads.empty()) {
      const auto it = bricks_.find(coord);
      if (it == bricks_.end()) continue;
      eraseQuads(coord, it->second, sink);
      quads_ -= it->second.mesh->quads.size();
      vertexRanges_.release(it->second.firstVertex, it->second.vertexCapacity);
      bricks_.erase(it);
      rewrite.erase(coord);
      continue;
    }
    BrickEntry& brick = bricks_[coord];
    if (brick.mesh && brick.mesh->serial == mesh->serial) continue;
    quads_ += mesh->quads.size() - (brick.mesh ? brick.mesh->quads.size() : 0);
    // Meshes that differ in quads alone share their vertices.
    const bool sameVertices = brick.mesh && brick.mesh->positions.data() == mesh->positions.data() &&
                              brick.mesh->positions.size() == mesh->positions.size();
    brick.mesh = mesh;
    rewrite.insert(coord);
    if (sameVertices || !writeVertices(coord, brick, sink)) continue;
    for (int n = 1; n < 8; ++n) {
      const Coord neighbour = coord + Coord{n & 1, (n >> 1) & 1, n >> 2};
      if (bricks_.count(neighbour) != 0) rewrite.insert(neighbour);
    }
  }

  for (const auto& [coord, added] : growth) {
    Chunk& chunk = chunks_[coord];
    const int64_t wanted = int64_t(chunk.quads.used()) + added;
    if (wanted > int64_t(chunk.quads.capacity())) resizeChunk(chunk, withChunkSlack(uint64_t(wanted)), sink);
  }
  for (const Coord coord : rewrite) placeQuads(coord, bricks_.at(coord), sink);
  rebuildDraws();
}

bool SurfaceLayout::writeVertices(Coord coord, BrickEntry& brick, UploadSink& sink) {
  const clay::BrickMesh& mesh = *brick.mesh;
  if (mesh.normals.size() != mesh.positions.size()) {
    throw Error("the surface to be drawn has no normals; make it with normals", Error::Kind::work);
  }
  bool moved = false;
  const auto count = uint32_t(mesh.positions.size());
  if (count > brick.vertexCapacity || withSlack(count) < brick.vertexCapacity / 2) {
    vertexRanges_.release(brick.firstVertex, brick.vertexCapacity);
    brick.vertexCapacity = withSlack(count);
    brick.firstVertex = count > 0 ? take(vertexRanges_, brick.vertexCapacity, sink) : 0;
    moved = true;
  }
  if (count == 0) return moved;
  brick.min = brick.max = mesh.positions[0];
  vertexScratch_.resize(count);
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3f& p = mesh.positions[i];
    brick.min = brick.min.cwiseMin(p);
    brick.max = brick.max.cwiseMax(p);
    vertexScratch_[i] = {fixedPoint(coord.x * clay::kBrickEdge, p.x()), fixedPoint(coord.y * clay::kBrickEdge, p.y()),
                         fixedPoint(coord.z * clay::kBrickEdge, p.z()), mesh.normals[i]};
  }
  sink.writeVertices(brick.firstVertex, vertexScratch_);
  return moved;
}

void SurfaceLayout::placeQuads(Coord coord, BrickEntry& brick, UploadSink& sink) {
  const auto count = uint32_t(brick.mesh->quads.size());
  Chunk& chunk = chunks_[coord >> kChunkBits];
  if (count > brick.quadCapacity || withSlack(count) < brick.quadCapacity / 2) {
    eraseQuads(coord, brick, sink);
    if (count == 0) return;
    const uint32_t capacity = withSlack(count);
    auto place = chunk.quads.allocate(capacity);
    if (!place) {
      // Enough room in all but not in one piece: pack the block anew.
      resizeChunk(chunk, withChunkSlack(uint64_t(chunk.quads.used()) + capacity), sink);
      place = chunk.quads.allocate(capacity);
    }
    brick.firstQuad = *place;
    brick.quadCapacity = capacity;
    chunk.bricks.insert(std::lower_bound(chunk.bricks.begin(), chunk.bricks.end(), coord), coord);
  }
  if (brick.quadCapacity > 0) writeQuads(coord, brick, chunk, sink);
}

void SurfaceLayout::writeQuads(Coord coord, const BrickEntry& brick, const Chunk& chunk, UploadSink& sink) {
  const auto quads = brick.mesh->quads;
  struct Base {
    uint32_t first = 0, count = 0;
  };
  Base bases[8];
  for (int n = 0; n < 8; ++n) {
    const auto it = bricks_.find(coord - Coord{n & 1, (n >> 1) & 1, n >> 2});
    if (it != bricks_.end()) bases[n] = {it->second.firstVertex, uint32_t(it->second.mesh->positions.size())};
  }
  const auto resolve = [&](clay::VertexRef ref) {
    const Base& base = bases[ref >> clay::kVertexRefBits];
    const uint32_t index = ref & clay::kVertexRefIndex;
    if (index >= base.count) {
      throw Error("the surface is incomplete: a quad names a vertex that no brick has; report this with the clay file",
                  Error::Kind::work);
    }
    return base.first + index;
  };
  // The rest of the range is filled with empty triangles, so that a chunk is one draw call.
  indexScratch_.assign(size_t(brick.quadCapacity) * kIndicesPerQuad, 0);
  uint32_t* out = indexScratch_.data();
  for (const auto& quad : quads) {
    const uint32_t a = resolve(quad[0]), b = resolve(quad[1]), c = resolve(quad[2]), d = resolve(quad[3]);
    for (const uint32_t index : {a, b, c, a, c, d}) *out++ = index;
  }
  sink.writeIndices((chunk.firstQuad + brick.firstQuad) * kIndicesPerQuad, indexScratch_);
}

void SurfaceLayout::eraseQuads(Coord coord, BrickEntry& brick, UploadSink& sink) {
  if (brick.quadCapacity == 0) return;
  Chunk& chunk = chunks_.at(coord >> kChunkBits);
  indexScratch_.assign(size_t(brick.quadCapacity) * kIndicesPerQuad, 0);
  sink.writeIndices((chunk.firstQuad + brick.firstQuad) * kIndicesPerQuad, indexScratch_);
  chunk.quads.release(brick.firstQuad, brick.quadCapacity);
  chunk.bricks.erase(std::lower_bound(chunk.bricks.begin(), chunk.bricks.end(), coord));
  brick.quadCapacity = 0;
}

void SurfaceLayout::resizeChunk(Chunk& chunk, uint32_t capacity, UploadSink& sink) {
  quadRanges_.release(chunk.firstQuad, chunk.quads.capacity());
  chunk.firstQuad = take(quadRanges_, capacity, sink);
  chunk.quads = RangeAllocator(capacity);
  for (const Coord coord : chunk.bricks) {
    BrickEntry& brick = bricks_.at(coord);
    brick.firstQuad = *chunk.quads.allocate(brick.quadCapacity);
  }
  // What lies past the packed bricks is never drawn; only the bricks are written.
  for (const Coord coord : chunk.bricks) {
    const BrickEntry& brick = bricks_.at(coord);
    if (brick.mesh->quads.size() <= brick.quadCapacity) writeQuads(coord, brick, chunk, sink);
  }
}

void SurfaceLayout::rebuildDraws() {
  draws_.clear();
  for (auto it = chunks_.begin(); it != chunks_.end();) {
    Chunk& chunk = it->second;
    if (chunk.bricks.empty()) {
      quadRanges_.release(chunk.firstQuad, chunk.quads.capacity());
      it = chunks_.erase(it);
      continue;
    }
    Coord lo = chunk.bricks.front(), hi = lo;
    for (const Coord c : chunk.bricks) {
      lo = {std::min(lo.x, c.x), std::min(lo.y, c.y), std::min(lo.z, c.z)};
      hi = {std::max(hi.x, c.x), std::max(hi.y, c.y), std::max(hi.z, c.z)};
    }
    // A quad reaches one cell into the bricks below its own.
    ChunkDraw draw;
    draw.firstVoxel = it->first * (clay::kBrickEdge << kChunkBits);
    draw.firstIndex = chunk.firstQuad * kIndicesPerQuad;
    draw.indexCount = chunk.quads.end() * kIndicesPerQuad;
    draw.min = (lo * clay::kBrickEdge).toVec3d() - Vec3d::Ones();
    draw.max = (hi * clay::kBrickEdge).toVec3d() + Vec3d::Constant(clay::kBrickEdge);
    draws_.push_back(draw);
    ++it;
  }
}

Box SurfaceLayout::bounds() const {
  Box box;
  for (const auto& [coord, brick] : bricks_) {
    if (brick.mesh->positions.empty()) continue;
    const Vec3d base = (coord * clay::kBrickEdge).toVec3d();
    box.add(base + brick.min.cast<double>());
    box.add(base + brick.max.cast<double>());
  }
  if (!box.empty()) {
    box.min = grid_.toWorld(box.min);
    box.max = grid_.toWorld(box.max);
  }
  return box;
}

}  // namespace argil::render
