#include "render/surface/surface_layout.h"

#include <algorithm>
#include <cmath>
#include <set>

#include "clay/base/error.h"
#include "clay/surface/sharp_vertices.h"

namespace argil::render {
namespace {

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

void BufferRanges::reserve(uint64_t vertices, uint64_t quads, UploadSink& sink) {
  const auto grown = [](const RangeAllocator& ranges, uint64_t more) {
    const uint64_t end = ranges.end() + more;
    if (end <= ranges.capacity()) return uint64_t(ranges.capacity());
    return std::max<uint64_t>({kFirstCapacity, uint64_t(ranges.capacity()) * 3 / 2, end});
  };
  const uint64_t wantedVertices = grown(vertices_, vertices), wantedQuads = grown(quads_, quads);
  if (wantedVertices == vertices_.capacity() && wantedQuads == quads_.capacity()) return;
  if (std::max(wantedVertices, wantedQuads) > kMaxUnits) {
    throw Error("the surface has more triangles than the renderer can address; use larger voxels", Error::Kind::work);
  }
  sink.reserve(uint32_t(wantedVertices), uint32_t(wantedQuads) * kIndicesPerQuad);  // may throw: first
  vertices_.grow(uint32_t(wantedVertices));
  quads_.grow(uint32_t(wantedQuads));
}

uint32_t BufferRanges::takeVertices(uint32_t count, UploadSink& sink) {
  if (const auto begin = vertices_.allocate(count)) return *begin;
  reserve(count, 0, sink);
  return *vertices_.allocate(count);
}

uint32_t BufferRanges::takeQuads(uint32_t count, UploadSink& sink) {
  if (const auto begin = quads_.allocate(count)) return *begin;
  reserve(0, count, sink);
  return *quads_.allocate(count);
}

void SurfaceLayout::clear() {
  for (auto& [coord, brick] : bricks_) ranges_->releaseVertices(brick.firstVertex, brick.vertexCapacity);
  for (auto& [coord, chunk] : chunks_) {
    dropLevels(chunk);
    ranges_->releaseQuads(chunk.firstQuad, chunk.quads.capacity());
  }
  bricks_.clear();
  chunks_.clear();
  draws_.clear();
  loose_ = Box();
  quads_ = 0;
  whole_ = true;
}

/// Chunks that will grow get their block at once, and the buffers their size: a first load packs each chunk and makes
/// each buffer a single time.
void SurfaceLayout::reserveFor(const clay::SurfaceDelta& delta, std::map<Coord, int64_t>& growth, UploadSink& sink) {
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
  ranges_->reserve(newVertices, newQuads, sink);
}

void SurfaceLayout::apply(const clay::SurfaceDelta& delta, UploadSink& sink) {
  std::map<Coord, int64_t> growth;
  reserveFor(delta, growth, sink);
  whole_ = false;  // until all is done
  grid_ = delta.grid;

  std::set<Coord> rewrite, changedChunks, repaint;
  for (const clay::BrickMeshPtr& mesh : delta.changed) {
    const Coord coord = mesh->brick;
    const auto known = bricks_.find(coord);
    if (mesh->positions.empty() && mesh->quads.empty()) {
      if (known == bricks_.end()) continue;
      changedChunks.insert(coord >> kChunkBits);
      eraseQuads(coord, known->second, sink);
      quads_ -= known->second.mesh->quads.size();
      ranges_->releaseVertices(known->second.firstVertex, known->second.vertexCapacity);
      bricks_.erase(known);
      rewrite.erase(coord);
      repaint.erase(coord);
      continue;
    }
    BrickEntry& brick = known != bricks_.end() ? known->second : bricks_[coord];
    if (brick.mesh && brick.mesh->serial == mesh->serial) continue;
    quads_ += mesh->quads.size() - (brick.mesh ? brick.mesh->quads.size() : 0);
    changedChunks.insert(coord >> kChunkBits);
    const bool sameVertices = brick.mesh && brick.mesh->vertexSerial == mesh->vertexSerial;
    brick.mesh = mesh;
    rewrite.insert(coord);
    if (sameVertices) continue;
    brick.paint.reset();  // what is painted comes with the same delta
    repaint.insert(coord);
    const bool moved = writeVertices(brick, sink);
    for (int n = 1; n < 8; ++n) {
      const Coord neighbour = coord + Coord{n & 1, (n >> 1) & 1, n >> 2};
      const bool inChunk = neighbour >> kChunkBits == coord >> kChunkBits;
      if ((inChunk && !moved) || bricks_.count(neighbour) == 0) continue;
      // Its triangles have other corners, so its chunk another cone.
      if (!inChunk) changedChunks.insert(neighbour >> kChunkBits);
      if (moved) rewrite.insert(neighbour);
    }
  }

  for (const std::shared_ptr<const clay::BrickPaint>& paint : delta.painted) {
    const auto known = bricks_.find(paint->brick);
    if (known == bricks_.end()) continue;
    const bool fits = paint->vertices.size() == known->second.mesh->positions.size();
    known->second.paint = fits ? paint : nullptr;
    repaint.insert(paint->brick);
    if (fits) ranges_->setPainted();
    // Coarser levels have vertices of their own.
    changedChunks.insert(paint->brick >> kChunkBits);
    for (int n = 1; n < 8; ++n) changedChunks.insert((paint->brick + Coord{n & 1, (n >> 1) & 1, n >> 2}) >> kChunkBits);
  }
  if (ranges_->painted())
    for (const Coord coord : repaint) writePaint(bricks_.at(coord), sink);
  noteUnseen(repaint, rewrite, changedChunks);

  for (const auto& [coord, added] : growth) {
    Chunk& chunk = chunks_[coord];
    const int64_t wanted = int64_t(chunk.quads.used()) + added;
    if (wanted <= int64_t(chunk.quads.capacity())) continue;
    resizeChunk(chunk, withChunkSlack(uint64_t(wanted)), sink);
    changedChunks.insert(coord);
  }
  for (const Coord coord : rewrite) placeQuads(coord, bricks_.at(coord), sink);
  for (const auto& [coord, added] : growth) {
    if (chunks_.at(coord).bricks.empty()) changedChunks.insert(coord);
  }
  updateDraws(changedChunks);
  whole_ = true;
}

SurfaceVertex SurfaceLayout::vertexOf(const clay::BrickMesh& mesh, size_t index) {
  const Coord base = mesh.brick * clay::kBrickEdge;
  const Vec3f& p = mesh.positions[index];
  return {fixedPoint(base.x, p.x()), fixedPoint(base.y, p.y()), fixedPoint(base.z, p.z()), mesh.normals[index]};
}

PackedPaint packPaint(const clay::VertexPaint& paint, const MaterialColours& materials) {
  constexpr float kMaskDarkens = 0.55f;  // what a whole mask takes of the light
  const auto linear = [](uint8_t byte) {
    const float c = float(byte) / 255;
    return c <= 0.04045f ? c / 12.92f : std::pow((c + 0.055f) / 1.055f, 2.4f);
  };
  const float light = 1 - kMaskDarkens * float(paint.mask) / 255, cover = float(paint.cover) / 255;
  const auto byte = [](float value) { return uint32_t(std::clamp(value, 0.0f, 1.0f) * 255 + 0.5f); };
  // A material that has a colour takes the place of the piece's own.
  const auto* ground = paint.material > 0 && paint.material <= materials.size() && materials[paint.material - 1u]
                           ? &*materials[paint.material - 1u]
                           : nullptr;
  const auto root = [&](uint8_t channel, size_t of) {
    return byte(std::sqrt((linear(channel) * cover + (ground ? linear((*ground)[of]) * (1 - cover) : 0)) * light));
  };
  return root(paint.red, 0) | root(paint.green, 1) << 8 | root(paint.blue, 2) << 16 |
         byte(ground ? 0 : (1 - cover) * light) << 24;
}

PackedPaint SurfaceLayout::paintOf(const BrickEntry& brick, size_t index) const {
  return brick.paint ? packPaint(brick.paint->vertices[index], materials_) : kUnpainted;
}

void SurfaceLayout::colourMaterials(const MaterialColours& colours, UploadSink& sink) {
  if (materials_ == colours) return;
  materials_ = colours;
  std::set<Coord> changedChunks;
  for (const auto& [coord, brick] : bricks_) {
    if (!brick.paint) continue;
    writePaint(brick, sink);
    // Their coarser levels.
    for (int n = 0; n < 8; ++n) changedChunks.insert((coord + Coord{n & 1, (n >> 1) & 1, n >> 2}) >> kChunkBits);
  }
  updateDraws(changedChunks);
}

void SurfaceLayout::writePaint(const BrickEntry& brick, UploadSink& sink) {
  const size_t count = brick.mesh->positions.size();
  if (count == 0) return;
  paintScratch_.resize(count);
  for (size_t i = 0; i < count; ++i) paintScratch_[i] = paintOf(brick, i);
  sink.writePaint(brick.firstVertex, paintScratch_);
}

bool SurfaceLayout::writeVertices(BrickEntry& brick, UploadSink& sink) {
  const clay::BrickMesh& mesh = *brick.mesh;
  if (mesh.normals.size() != mesh.positions.size()) {
    throw Error("the surface to be drawn has no normals; make it with normals", Error::Kind::work);
  }
  bool moved = false;
  const auto count = uint32_t(mesh.positions.size());
  if (count > brick.vertexCapacity || withSlack(count) < brick.vertexCapacity / 2) {
    ranges_->releaseVertices(brick.firstVertex, brick.vertexCapacity);
    brick.vertexCapacity = withSlack(count);
    brick.firstVertex = count > 0 ? ranges_->takeVertices(brick.vertexCapacity, sink) : 0;
    moved = true;
  }
  if (count == 0) return moved;
  brick.min = brick.max = mesh.positions[0];
  vertexScratch_.resize(count);
  for (uint32_t i = 0; i < count; ++i) {
    const Vec3f& p = mesh.positions[i];
    brick.min = brick.min.cwiseMin(p);
    brick.max = brick.max.cwiseMax(p);
    vertexScratch_[i] = vertexOf(mesh, i);
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

std::array<SurfaceLayout::Base, 8> SurfaceLayout::basesOf(Coord coord) const {
  std::array<Base, 8> bases;
  for (int n = 0; n < 8; ++n) {
    const auto it = bricks_.find(coord - Coord{n & 1, (n >> 1) & 1, n >> 2});
    if (it == bricks_.end()) continue;
    bases[size_t(n)] = {&it->second, it->second.firstVertex, uint32_t(it->second.mesh->positions.size())};
  }
  return bases;
}

void SurfaceLayout::writeQuads(Coord coord, const BrickEntry& brick, const Chunk& chunk, UploadSink& sink) {
  const auto quads = brick.mesh->quads;
  const std::array<Base, 8> bases = basesOf(coord);
  const auto resolve = [&](clay::VertexRef ref) {
    const Base& base = bases[size_t(ref >> clay::kVertexRefBits)];
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
    if (unseen(bases, quad)) continue;
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
  ranges_->releaseQuads(chunk.firstQuad, chunk.quads.capacity());
  chunk.quads = RangeAllocator();
  chunk.firstQuad = ranges_->takeQuads(capacity, sink);
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

void SurfaceLayout::updateDraws(const std::set<Coord>& changed) {
  bool otherChunks = false;
  for (const Coord coord : changed) {
    const auto it = chunks_.find(coord);
    if (it == chunks_.end()) continue;
    Chunk& chunk = it->second;
    dropLevels(chunk);
    if (chunk.bricks.empty()) {
      ranges_->releaseQuads(chunk.firstQuad, chunk.quads.capacity());
      chunks_.erase(it);
      otherChunks = true;
      continue;
    }
    otherChunks |= chunk.draw == SIZE_MAX;
  }
  if (otherChunks) {
    std::vector<ChunkDraw> before = std::move(draws_);
    draws_.clear();
    draws_.reserve(chunks_.size());
    for (auto& [coord, chunk] : chunks_) {
      draws_.push_back(chunk.draw == SIZE_MAX ? ChunkDraw() : before[chunk.draw]);
      chunk.draw = draws_.size() - 1;
    }
  }
  for (const Coord coord : changed) {
    const auto it = chunks_.find(coord);
    if (it == chunks_.end()) continue;
    const Chunk& chunk = it->second;
    Coord lo = chunk.bricks.front(), hi = lo;
    uint32_t quads = 0;
    for (const Coord c : chunk.bricks) {
      lo = {std::min(lo.x, c.x), std::min(lo.y, c.y), std::min(lo.z, c.z)};
      hi = {std::max(hi.x, c.x), std::max(hi.y, c.y), std::max(hi.z, c.z)};
      quads += uint32_t(bricks_.at(c).mesh->quads.size());
    }
    ChunkDraw& draw = draws_[chunk.draw];
    const bool isNew = !draw.levels[0].made;
    draw = ChunkDraw();
    draw.chunk = coord;
    // What is there for the first time does not wait for its levels.
    draw.changedIn = isNew ? picture_ - kRestPictures : picture_;
    // A quad reaches one cell into the bricks below its own, a fine vertex out of its cell.
    draw.min = (lo * clay::kBrickEdge).toVec3d() - Vec3d::Constant(1 + clay::kSharpReach);
    draw.max = (hi * clay::kBrickEdge).toVec3d() + Vec3d::Constant(clay::kBrickEdge + clay::kSharpReach);
    draw.levels[0] = {chunk.firstQuad * kIndicesPerQuad, chunk.quads.end() * kIndicesPerQuad, 2 * quads, true};
  }
  loose_ = Box();
  for (const ChunkDraw& draw : draws_) {
    loose_.add(grid_.toWorld(draw.min));
    loose_.add(grid_.toWorld(draw.max));
  }
}

const Box& SurfaceLayout::tightBox(const Chunk& chunk) const {
  if (chunk.tight) return *chunk.tight;
  Box box;
  for (const Coord coord : chunk.bricks) {
    const std::array<Base, 8> bases = basesOf(coord);
    for (size_t n = 0; n < 8; ++n) {
      if (!bases[n].brick || bases[n].count == 0) continue;
      const Vec3d base = (bases[n].brick->mesh->brick * clay::kBrickEdge).toVec3d();
      box.add(base + bases[n].brick->min.cast<double>());
      box.add(base + bases[n].brick->max.cast<double>());
    }
  }
  chunk.tight = box;
  return *chunk.tight;
}

Box SurfaceLayout::bounds(const Eigen::Quaterniond& rotation, const Vec3d& translation) const {
  const bool turned = !rotation.vec().isZero(0);
  const auto place = [&](const Vec3d& voxel) -> Vec3d { return rotation * grid_.toWorld(voxel) + translation; };
  Box box;
  for (const auto& [coord, chunk] : chunks_) {
    const Box& tight = tightBox(chunk);
    if (tight.empty()) continue;
    if (!turned) {
      box.add(place(tight.min));
      box.add(place(tight.max));
      continue;
    }
    // A turned box is wider than what is in it: where it would widen the whole, the vertices themselves are asked.
    Box outer;
    for (int corner = 0; corner < 8; ++corner) {
      outer.add(place({(corner & 1) ? tight.max.x() : tight.min.x(), (corner & 2) ? tight.max.y() : tight.min.y(),
                       (corner & 4) ? tight.max.z() : tight.min.z()}));
    }
    if (!box.empty() && (outer.min.array() >= box.min.array()).all() && (outer.max.array() <= box.max.array()).all()) {
      continue;
    }
    for (const Coord brick : chunk.bricks) {
      for (const Base& base : basesOf(brick)) {
        if (!base.brick) continue;
        const Vec3d zero = (base.brick->mesh->brick * clay::kBrickEdge).toVec3d();
        for (const Vec3f& p : base.brick->mesh->positions) box.add(place(zero + p.cast<double>()));
      }
    }
  }
  return box;
}

}  // namespace argil::render
