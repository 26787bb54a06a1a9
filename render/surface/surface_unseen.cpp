// What of the clay is not drawn: the unseen material, and masked clay of a piece that hides it.

#include <algorithm>

#include "render/surface/surface_layout.h"

namespace argil::render {

bool SurfaceLayout::unseen(const Bases& bases, const std::array<clay::VertexRef, 4>& quad) const {
  return std::all_of(quad.begin(), quad.end(), [&](clay::VertexRef ref) {
    const BrickEntry* owner = bases[size_t(ref >> clay::kVertexRefBits)].brick;
    return owner && owner->unseen && owner->paint && unseen(owner->paint->vertices[ref & clay::kVertexRefIndex]);
  });
}

// Triangles of a brick and of those above it name its vertices.
void SurfaceLayout::noteUnseen(const std::set<Coord>& repainted, std::set<Coord>& rewrite,
                               std::set<Coord>& changedChunks) {
  for (const Coord coord : repainted) {
    BrickEntry& brick = bricks_.at(coord);
    const bool before = brick.unseen;
    brick.unseen = brick.paint && std::any_of(brick.paint->vertices.begin(), brick.paint->vertices.end(),
                                              [&](const clay::VertexPaint& paint) { return unseen(paint); });
    if (!before && !brick.unseen) continue;
    for (int n = 0; n < 8; ++n) {
      const Coord above = coord + Coord{n & 1, (n >> 1) & 1, n >> 2};
      if (bricks_.count(above) == 0) continue;
      rewrite.insert(above);
      changedChunks.insert(above >> kChunkBits);
    }
  }
}

void SurfaceLayout::hideMasked(bool hide, UploadSink& sink) {
  if (hideMasked_ == hide) return;
  hideMasked_ = hide;
  std::set<Coord> painted, rewrite, changedChunks;
  for (const auto& [coord, brick] : bricks_)
    if (brick.paint) painted.insert(coord);
  noteUnseen(painted, rewrite, changedChunks);
  for (const Coord coord : rewrite) placeQuads(coord, bricks_.at(coord), sink);
  updateDraws(changedChunks);
}

}  // namespace argil::render
