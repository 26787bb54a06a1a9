#pragma once
// What an update of a layout does, chunk by chunk. This folder's own.

#include <bit>

#include "render/surface/surface_layout.h"

namespace argil::render {

/// Calls `visit(place)` for each bit that is set, in order.
template <class Bits, class Visit>
void forEachPlace(const Bits& bits, const Visit& visit) {
  for (size_t word = 0; word < bits.size(); ++word)
    for (uint64_t left = bits[word]; left != 0; left &= left - 1) visit(word * 64 + size_t(std::countr_zero(left)));
}

struct SurfaceLayout::ChunkWork {
  explicit ChunkWork(Chunk& of) : chunk(of) {}
  Chunk& chunk;
  BrickBits rewrite{}, repaint{};  // bricks whose indices, whose paint is written
  struct Range {
    uint32_t first, count;
  };
  std::vector<Range> freed;  // of the block: to be emptied and given back when all others are placed
  bool changed = false;      // its draw is made anew

  static void set(BrickBits& bits, size_t place) { bits[place >> 6] |= uint64_t{1} << (place & 63); }
  static void reset(BrickBits& bits, size_t place) { bits[place >> 6] &= ~(uint64_t{1} << (place & 63)); }
  void setChanged(size_t place) {
    changed = true;
    set(rewrite, place);
  }
  // The brick has no quads any more, or will have them elsewhere.
  void free(BrickEntry& brick, size_t place) {
    if (brick.quadCapacity == 0) return;
    freed.push_back({brick.firstQuad, brick.quadCapacity});
    brick.quadCapacity = 0;
    reset(chunk.drawn, place);
  }
};

/// Bricks come in an order in which most are of the chunk of the one before.
class SurfaceLayout::Works {
 public:
  explicit Works(std::map<Coord, Chunk>& chunks) : chunks_(chunks) {}

  /// Null for a chunk that is not there.
  ChunkWork* find(Coord chunk) {
    if (last_ && last_->chunk.coord == chunk) return last_;
    const auto it = chunks_.find(chunk);
    return it == chunks_.end() ? nullptr : take(it->second);
  }
  ChunkWork& at(Coord chunk) {
    if (last_ && last_->chunk.coord == chunk) return *last_;
    Chunk& there = chunks_[chunk];
    there.coord = chunk;
    return *take(there);
  }
  /// In order of chunk coordinate.
  [[nodiscard]] std::map<Coord, ChunkWork>& all() { return works_; }
  [[nodiscard]] const std::map<Coord, ChunkWork>& all() const { return works_; }

 private:
  ChunkWork* take(Chunk& chunk) { return last_ = &works_.try_emplace(chunk.coord, chunk).first->second; }

  std::map<Coord, Chunk>& chunks_;
  std::map<Coord, ChunkWork> works_;
  ChunkWork* last_ = nullptr;
};

}  // namespace argil::render
