// What of the clay is not drawn: the unseen material, and masked clay of a piece that hides it.

#include <algorithm>

#include "render/surface/chunk_works.h"

namespace argil::render {

bool SurfaceLayout::unseen(const Bases& bases, const std::array<clay::VertexRef, 4>& quad) const {
  return std::all_of(quad.begin(), quad.end(), [&](clay::VertexRef ref) {
    const BrickEntry* owner = bases[size_t(ref >> clay::kVertexRefBits)].brick;
    return owner && owner->unseen && owner->paint && unseen(owner->paint->vertices[ref & clay::kVertexRefIndex]);
  });
}

// Triangles of a brick and of those above it name its vertices.
void SurfaceLayout::noteUnseen(Works& works) {
  // Chunks that come on top have nothing repainted.
  std::vector<std::pair<Chunk*, BrickBits>> repainted;
  for (const auto& [coord, work] : works.all()) repainted.emplace_back(&work.chunk, work.repaint);
  for (const auto& [chunk, places] : repainted) {
    forEachPlace(places, [&](size_t place) {
      BrickEntry& brick = *chunk->bricks[place];
      const bool before = brick.unseen;
      brick.unseen = brick.paint && std::any_of(brick.paint->vertices.begin(), brick.paint->vertices.end(),
                                                [&](const clay::VertexPaint& paint) { return unseen(paint); });
      if (!before && !brick.unseen) return;
      for (int n = 0; n < 8; ++n) {
        const Coord above = brickAt(*chunk, place) + Coord{n & 1, (n >> 1) & 1, n >> 2};
        ChunkWork* const work = works.find(above >> kChunkBits);
        if (work && work->chunk.bricks[placeOf(above)]) work->setChanged(placeOf(above));
      }
    });
  }
}

void SurfaceLayout::hideMasked(bool hide, UploadSink& sink) {
  if (hideMasked_ == hide) return;
  hideMasked_ = hide;
  Works works(chunks_);
  for (const auto& [coord, chunk] : chunks_)
    for (size_t place = 0; place < kChunkBricks; ++place)
      if (chunk.bricks[place] && chunk.bricks[place]->paint) ChunkWork::set(works.at(coord).repaint, place);
  noteUnseen(works);
  placeQuads(works, sink);
  updateDraws(works, {});
}

}  // namespace argil::render
