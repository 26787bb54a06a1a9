#include "render/surface/surface_layout.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "clay/base/error.h"
#include "clay/surface/rim_vertices.h"
#include "render/surface/chunk_works.h"

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

int32_t fixedPoint(int32_t voxel, int32_t units) {
  return int32_t(std::clamp<int64_t>(int64_t(voxel) * kUnitsPerVoxel + units, INT32_MIN, INT32_MAX));
}

}  // namespace

void BufferRanges::reserve(uint64_t vertices, uint64_t quads, UploadSink& sink) {
  const auto grown = [](const RangeAllocator& ranges, uint64_t more, bool room) {
    uint64_t end = ranges.end() + more;
    if (end <= ranges.capacity()) return uint64_t(ranges.capacity());
    if (room) end = std::max(end, std::min<uint64_t>(end + end / 4, kMaxUnits));
    return std::max<uint64_t>({kFirstCapacity, uint64_t(ranges.capacity()) * 3 / 2, end});
  };
  for (bool room = leavesRoom_;; room = false) {
    const uint64_t wantedVertices = grown(vertices_, vertices, room), wantedQuads = grown(quads_, quads, room);
    if (wantedVertices == vertices_.capacity() && wantedQuads == quads_.capacity()) return;
    if (std::max(wantedVertices, wantedQuads) > kMaxUnits) {
      throw Error("the surface has more triangles than the renderer can address; use larger voxels", Error::Kind::work);
    }
    try {
      sink.reserve(uint32_t(wantedVertices), uint32_t(wantedQuads) * kIndicesPerQuad);  // first: nothing changed yet
    } catch (const Error&) {
      if (room) continue;
      if (!makeRoom_ || !makeRoom_()) throw;
      return;  // What is free now may be enough in pieces.
    }
    vertices_.grow(uint32_t(wantedVertices));
    quads_.grow(uint32_t(wantedQuads));
    return;
  }
}

uint32_t BufferRanges::takeVertices(uint32_t count, UploadSink& sink) {
  for (;;) {
    if (const auto begin = vertices_.allocate(count)) return *begin;
    reserve(count, 0, sink);
  }
}

uint32_t BufferRanges::takeQuads(uint32_t count, UploadSink& sink) {
  for (;;) {
    if (const auto begin = quads_.allocate(count)) return *begin;
    reserve(0, count, sink);
  }
}

void SurfaceLayout::releaseChunk(Chunk& chunk) {
  for (const auto& brick : chunk.bricks)
    if (brick) ranges_->releaseVertices(brick->firstVertex, brick->vertexCapacity);
  dropLevels(chunk);
  ranges_->releaseQuads(chunk.firstQuad, chunk.quads.capacity());
}

void SurfaceLayout::clear() {
  dropKept();
  for (auto& [coord, chunk] : chunks_) releaseChunk(chunk);
  chunks_.clear();
  bricks_ = 0;
  draws_.clear();
  loose_ = Box();
  quads_ = 0;
  whole_ = true;
}

size_t SurfaceLayout::placeOf(Coord brick) {
  return size_t(clay::Brick::offset(brick.x & 7, brick.y & 7, brick.z & 7));
}

Coord SurfaceLayout::brickAt(size_t place) {
  const auto at = int32_t(place);
  return {at >> 6, (at >> 3) & 7, at & 7};
}

const SurfaceLayout::Chunk* SurfaceLayout::chunkAt(Coord chunk) const {
  const auto it = chunks_.find(chunk);
  return it == chunks_.end() ? nullptr : &it->second;
}

const SurfaceLayout::BrickEntry* SurfaceLayout::find(Coord brick) const {
  const Chunk* chunk = chunkAt(brick >> kChunkBits);
  return chunk ? chunk->bricks[placeOf(brick)].get() : nullptr;
}

/// The buffers get their size at once: a first load makes each of them a single time.
void SurfaceLayout::reserveFor(std::span<const clay::BrickMeshPtr> changed, UploadSink& sink) {
  uint64_t newVertices = 0, newQuads = 0;
  std::map<Coord, int64_t> growth;
  Coord last{INT32_MIN, 0, 0};
  const Chunk* chunk = nullptr;
  int64_t* added = nullptr;
  for (const clay::BrickMeshPtr& mesh : changed) {
    if (const Coord coord = mesh->brick >> kChunkBits; !added || coord != last) {
      last = coord;
      chunk = chunkAt(coord);
      added = &growth[coord];
    }
    const BrickEntry* known = chunk ? chunk->bricks[placeOf(mesh->brick)].get() : nullptr;
    *added += int64_t(withSlack(mesh->quads.size())) - (known ? int64_t(known->quadCapacity) : 0);
    const uint32_t vertices = withSlack(mesh->positions.size());
    if (!known || vertices > known->vertexCapacity) newVertices += vertices;
  }
  for (const auto& [coord, more] : growth) {
    const Chunk* grows = chunkAt(coord);
    const int64_t used = grows ? grows->quads.used() : 0, capacity = grows ? grows->quads.capacity() : 0;
    if (used + more > capacity) newQuads += withChunkSlack(uint64_t(used + more));
  }
  ranges_->reserve(newVertices, newQuads, sink);
}

void SurfaceLayout::apply(const clay::SurfaceDelta& delta, UploadSink& sink) {
  const bool exchanges = delta.keepsBefore && whole_;
  const uint64_t before = quads_;
  if (!exchanges) reserveFor(delta.changed, sink);
  whole_ = false;  // until all is done
  grid_ = delta.grid;
  Exchange exchange;
  if (exchanges) {
    exchange = exchangeKept(delta);
    reserveFor(exchange.rest, sink);
  }
  Works works(chunks_);
  for (const clay::BrickMeshPtr& mesh : exchanges ? exchange.rest : delta.changed) takeMesh(mesh, works, sink);
  rewriteAround(exchange, works);
  takePaint(delta, works);
  if (ranges_->painted()) {
    for (const auto& [coord, work] : works.all())
      forEachPlace(work.repaint, [&](size_t place) { writePaint(*work.chunk.bricks[place], sink); });
  }
  noteUnseen(works);
  placeQuads(works, sink);
  updateDraws(works, exchange);
  if (exchanges) dropKept(std::min(mostKept_, std::max(before, quads_)));
  whole_ = true;
}

void SurfaceLayout::takeMesh(const clay::BrickMeshPtr& mesh, Works& works, UploadSink& sink) {
  const Coord coord = mesh->brick;
  const size_t place = placeOf(coord);
  const bool none = mesh->positions.empty() && mesh->quads.empty();
  ChunkWork* const known = none ? works.find(coord >> kChunkBits) : &works.at(coord >> kChunkBits);
  if (!known) return;
  ChunkWork& work = *known;
  std::unique_ptr<BrickEntry>& brick = work.chunk.bricks[place];
  if (none) {
    if (!brick) return;
    work.changed = true;
    work.free(*brick, place);
    quads_ -= brick->mesh->quads.size();
    ranges_->releaseVertices(brick->firstVertex, brick->vertexCapacity);
    brick.reset();
    --bricks_;
    --work.chunk.held;
    ChunkWork::reset(work.rewrite, place);
    ChunkWork::reset(work.repaint, place);
    return;
  }
  if (!brick) {
    brick = std::make_unique<BrickEntry>();
    ++bricks_;
    ++work.chunk.held;
  } else if (brick->mesh->serial == mesh->serial) {
    return;
  }
  const clay::BrickMeshPtr before = std::exchange(brick->mesh, mesh);
  quads_ += mesh->quads.size() - (before ? before->quads.size() : 0);
  work.setChanged(place);
  if (before && before->vertexSerial == mesh->vertexSerial) return;
  brick->paint.reset();  // what is painted comes with the same delta
  ChunkWork::set(work.repaint, place);
  const bool moved = writeVertices(*brick, sink);
  work.chunk.stamp = ++stamps_;
  for (int n = 1; n < 8; ++n) {
    const Coord neighbour = coord + Coord{n & 1, (n >> 1) & 1, n >> 2};
    const bool inChunk = neighbour >> kChunkBits == coord >> kChunkBits;
    if (inChunk && !moved) continue;
    ChunkWork* const other = inChunk ? &work : works.find(neighbour >> kChunkBits);
    if (!other || !other->chunk.bricks[placeOf(neighbour)]) continue;
    // Its triangles have other corners, so its chunk another cone.
    if (!inChunk) other->changed = true;
    if (moved) ChunkWork::set(other->rewrite, placeOf(neighbour));
  }
}

void SurfaceLayout::takePaint(const clay::SurfaceDelta& delta, Works& works) {
  for (const std::shared_ptr<const clay::BrickPaint>& paint : delta.painted) {
    ChunkWork* const work = works.find(paint->brick >> kChunkBits);
    const size_t place = placeOf(paint->brick);
    BrickEntry* const brick = work ? work->chunk.bricks[place].get() : nullptr;
    if (!brick) continue;
    const bool fits = paint->vertices.size() == brick->mesh->positions.size();
    brick->paint = fits ? paint : nullptr;
    ChunkWork::set(work->repaint, place);
    if (fits) ranges_->setPainted();
    // Coarser levels have vertices of their own.
    for (int n = 0; n < 8; ++n) {
      ChunkWork* const above = works.find((paint->brick + Coord{n & 1, (n >> 1) & 1, n >> 2}) >> kChunkBits);
      if (above) above->changed = true;
    }
  }
}

SurfaceVertex SurfaceLayout::vertexOf(const clay::BrickMesh& mesh, size_t index) {
  const Coord base = mesh.brick * clay::kBrickEdge;
  const Units at = inUnits(mesh.positions[index]);
  return {fixedPoint(base.x, at[0]), fixedPoint(base.y, at[1]), fixedPoint(base.z, at[2]), mesh.normals[index]};
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
  Works works(chunks_);
  for (const auto& [coord, chunk] : chunks_) {
    for (size_t place = 0; place < kChunkBricks; ++place) {
      if (!chunk.bricks[place] || !chunk.bricks[place]->paint) continue;
      writePaint(*chunk.bricks[place], sink);
      // Their coarser levels.
      for (int n = 0; n < 8; ++n) {
        ChunkWork* const above = works.find((brickAt(chunk, place) + Coord{n & 1, (n >> 1) & 1, n >> 2}) >> kChunkBits);
        if (above) above->changed = true;
      }
    }
  }
  updateDraws(works, {});
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

// No range is written twice in an update: what is given back is emptied, or taken by others, after all are placed.
void SurfaceLayout::placeQuads(Works& works, UploadSink& sink) {
  for (auto& [coord, work] : works.all()) {
    Chunk& chunk = work.chunk;
    if (!rangesFor(work)) repack(work, sink);
    for (const ChunkWork::Range& range : work.freed) {
      indexScratch_.assign(size_t(range.count) * kIndicesPerQuad, 0);
      sink.writeIndices((chunk.firstQuad + range.first) * kIndicesPerQuad, indexScratch_);
      chunk.quads.release(range.first, range.count);
    }
    const Lower lower = lowerOf(chunk);
    forEachPlace(work.rewrite, [&](size_t place) {
      const BrickEntry& brick = *chunk.bricks[place];
      if (brick.quadCapacity > 0) writeQuads(brick, basesOf(lower, place), chunk, sink);
    });
  }
}

// Ranges in the block for the bricks that are to be written and need others; false when there is no room for one.
bool SurfaceLayout::rangesFor(ChunkWork& work) {
  bool room = true;
  forEachPlace(work.rewrite, [&](size_t place) {
    BrickEntry& brick = *work.chunk.bricks[place];
    const auto count = uint32_t(brick.mesh->quads.size());
    if (!room || (count <= brick.quadCapacity && withSlack(count) >= brick.quadCapacity / 2)) return;
    work.free(brick, place);
    if (count == 0) return;
    const auto range = work.chunk.quads.allocate(withSlack(count));
    room = range.has_value();
    if (!room) return;
    brick.firstQuad = *range;
    brick.quadCapacity = withSlack(count);
    ChunkWork::set(work.chunk.drawn, place);
  });
  return room;
}

// All of a chunk's bricks in a block of their own, elsewhere. What lies past them is never drawn, so they alone are
// written.
void SurfaceLayout::repack(ChunkWork& work, UploadSink& sink) {
  Chunk& chunk = work.chunk;
  work.freed.clear();
  uint64_t used = 0;
  for (const auto& brick : chunk.bricks) used += brick ? withSlack(brick->mesh->quads.size()) : 0;
  ranges_->releaseQuads(chunk.firstQuad, chunk.quads.capacity());
  chunk.quads = RangeAllocator();
  const uint32_t capacity = withChunkSlack(used);
  chunk.firstQuad = ranges_->takeQuads(capacity, sink);
  chunk.quads = RangeAllocator(capacity);
  work.changed = true;
  chunk.drawn = {};
  for (size_t place = 0; place < kChunkBricks; ++place) {
    BrickEntry* const brick = chunk.bricks[place].get();
    if (!brick) continue;
    brick->quadCapacity = withSlack(brick->mesh->quads.size());
    if (brick->quadCapacity == 0) continue;
    brick->firstQuad = *chunk.quads.allocate(brick->quadCapacity);
    ChunkWork::set(chunk.drawn, place);
  }
  work.rewrite = chunk.drawn;
}

SurfaceLayout::Lower SurfaceLayout::lowerOf(const Chunk& chunk) const {
  Lower lower{&chunk};
  for (int n = 1; n < 8; ++n) lower[size_t(n)] = chunkAt(chunk.coord - Coord{n & 1, (n >> 1) & 1, n >> 2});
  return lower;
}

SurfaceLayout::Bases SurfaceLayout::basesOf(const Lower& lower, size_t place) {
  Bases bases;
  for (int n = 0; n < 8; ++n) {
    const Coord brick = brickAt(place) - Coord{n & 1, (n >> 1) & 1, n >> 2};
    const Chunk* chunk = lower[size_t(int(brick.x < 0) | int(brick.y < 0) << 1 | int(brick.z < 0) << 2)];
    const BrickEntry* there = chunk ? chunk->bricks[placeOf(brick)].get() : nullptr;
    if (there) bases[size_t(n)] = {there, there->firstVertex, uint32_t(there->mesh->positions.size())};
  }
  return bases;
}

void SurfaceLayout::writeQuads(const BrickEntry& brick, const Bases& bases, const Chunk& chunk, UploadSink& sink) {
  const auto resolve = [&](clay::VertexRef ref) {
    const Base& base = bases[size_t(ref >> clay::kVertexRefBits)];
    const uint32_t index = ref & clay::kVertexRefIndex;
    if (index >= base.count) {
      throw Error("the surface is incomplete: a quad names a vertex that no brick has; report this with the clay file",
                  Error::Kind::work);
    }
    return base.first + index;
  };
  const bool someUnseen =
      std::any_of(bases.begin(), bases.end(), [](const Base& base) { return base.brick && base.brick->unseen; });
  // The rest of the range is filled with empty triangles, so that a chunk is one draw call.
  indexScratch_.resize(size_t(brick.quadCapacity) * kIndicesPerQuad);
  uint32_t* out = indexScratch_.data();
  for (const auto& quad : brick.mesh->quads) {
    if (someUnseen && unseen(bases, quad)) continue;
    const uint32_t a = resolve(quad[0]), b = resolve(quad[1]), c = resolve(quad[2]), d = resolve(quad[3]);
    for (const uint32_t index : {a, b, c, a, c, d}) *out++ = index;
  }
  std::fill(out, indexScratch_.data() + indexScratch_.size(), 0);
  sink.writeIndices((chunk.firstQuad + brick.firstQuad) * kIndicesPerQuad, indexScratch_);
}

void SurfaceLayout::updateDraws(const Works& works, const Exchange& exchange) {
  bool otherChunks = exchange.otherChunks;
  for (const auto& [coord, work] : works.all()) {
    if (!work.changed) continue;
    Chunk& chunk = work.chunk;
    dropLevels(chunk);
    const bool drawn = std::any_of(chunk.drawn.begin(), chunk.drawn.end(), [](uint64_t word) { return word != 0; });
    otherChunks |= drawn != (chunk.draw != SIZE_MAX);
    if (drawn) continue;
    ranges_->releaseQuads(chunk.firstQuad, chunk.quads.capacity());
    chunk.quads = RangeAllocator();
  }
  if (otherChunks) {
    std::vector<ChunkDraw> before = std::move(draws_);
    draws_.clear();
    draws_.reserve(chunks_.size());
    for (auto& [coord, chunk] : chunks_) {
      const size_t was = std::exchange(chunk.draw, SIZE_MAX);
      if (chunk.quads.used() == 0) continue;
      const auto back = exchange.back.find(coord);
      draws_.push_back(back != exchange.back.end() ? back->second.draw : was == SIZE_MAX ? ChunkDraw() : before[was]);
      chunk.draw = draws_.size() - 1;
    }
  }
  for (const auto& [coord, work] : works.all()) {
    const Chunk& chunk = work.chunk;
    if (!work.changed) continue;
    if (chunk.draw == SIZE_MAX) {
      if (chunk.held == 0) chunks_.erase(coord);
      continue;
    }
    Coord lo{INT32_MAX, INT32_MAX, INT32_MAX}, hi{INT32_MIN, INT32_MIN, INT32_MIN};
    uint32_t quads = 0;
    forEachPlace(chunk.drawn, [&](size_t place) {
      const Coord c = brickAt(chunk, place);
      lo = {std::min(lo.x, c.x), std::min(lo.y, c.y), std::min(lo.z, c.z)};
      hi = {std::max(hi.x, c.x), std::max(hi.y, c.y), std::max(hi.z, c.z)};
      quads += uint32_t(chunk.bricks[place]->mesh->quads.size());
    });
    ChunkDraw& draw = draws_[chunk.draw];
    const bool isNew = !draw.levels[0].made;
    draw = ChunkDraw();
    draw.chunk = coord;
    // What is there for the first time does not wait for its levels.
    draw.changedIn = isNew ? picture_ - kRestPictures : picture_;
    // A quad reaches one cell into the bricks below its own, a vertex on a crease out of its cell.
    draw.min = (lo * clay::kBrickEdge).toVec3d() - Vec3d::Constant(1 + clay::kVertexReach);
    draw.max = (hi * clay::kBrickEdge).toVec3d() + Vec3d::Constant(clay::kBrickEdge + clay::kVertexReach);
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
  const Lower lower = lowerOf(chunk);
  forEachPlace(chunk.drawn, [&](size_t place) {
    for (const Base& base : basesOf(lower, place)) {
      if (!base.brick || base.count == 0) continue;
      const Vec3d zero = (base.brick->mesh->brick * clay::kBrickEdge).toVec3d();
      box.add(zero + base.brick->min.cast<double>());
      box.add(zero + base.brick->max.cast<double>());
    }
  });
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
    const Lower lower = lowerOf(chunk);
    forEachPlace(chunk.drawn, [&](size_t at) {
      for (const Base& base : basesOf(lower, at)) {
        if (!base.brick) continue;
        const Vec3d zero = (base.brick->mesh->brick * clay::kBrickEdge).toVec3d();
        for (const Vec3f& p : base.brick->mesh->positions) box.add(place(zero + p.cast<double>()));
      }
    });
  }
  return box;
}

}  // namespace argil::render
