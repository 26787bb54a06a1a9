#pragma once
// Bricks that are solved together, pass by pass. This module's own.

#include <algorithm>
#include <array>
#include <bit>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <utility>
#include <vector>

#include "clay/field/redistance.h"
#include "clay/field/scratch.h"
#include "clay/store/brick_margins.h"

namespace argil::clay {

/// Values of bricks, each pass computed from those of the pass before: a brick's own and, across its faces, `layers`
/// voxels of its neighbours; where a neighbour is not among the bricks, what stood there at the beginning. Rows of
/// eight voxels along z rest while nothing changes that they are computed from: what moves is a front, and most of a
/// brick lies before or behind it. The order of bricks and the count of threads change nothing.
///
/// 4.2 KB a brick, 256 bytes more a layer and face without a neighbour: memory that the thread keeps (scratch.h), for
/// one solver at a time (else std::logic_error), or its own.
template <int layers>
class JacobiSolver {
 public:
  static constexpr int kEdge = kBrickEdge + 2 * layers;
  static constexpr int kRow = 12;
  /// As paddedOffset (one layer) or wideOffset (two): a brick with its layers around it.
  static constexpr int offset(int x, int y, int z) { return (x * kEdge + y) * kRow + z; }
  static constexpr int kAroundSize = kEdge * kEdge * kRow + 16;

  enum class Memory { ofThread, own };
  /// `coords`: sorted, each once.
  JacobiSolver(std::span<const Coord> coords, int threads, Memory memory = Memory::ofThread)
      : beside_(besideEach(coords, kFaceSteps)), threads_(threads) {
    size_t rims = 0;
    for (auto& faces : beside_)
      for (ptrdiff_t& face : faces)
        if (face < 0) face = -1 - static_cast<ptrdiff_t>(rims++);
    if (memory == Memory::own) {
      own_ = {std::make_unique_for_overwrite<Solved[]>(coords.size()), std::make_unique_for_overwrite<Rim[]>(rims)};
      bricks_ = {own_.first.get(), coords.size()};
      rims_ = {own_.second.get(), rims};
    } else {
      hold_.emplace();
      bricks_ = Scratch::of<Solved>(coords.size(), Scratch::Room::bricks);
      rims_ = Scratch::of<Rim>(rims, Scratch::Room::rims);
    }
  }

  /// Whether the brick across a face (kFaceSteps) is solved too: else what stands there has to be known when brick i
  /// begins.
  [[nodiscard]] bool hasBeside(size_t i, size_t face) const { return beside_[i][face] >= 0; }

  /// What brick `i` begins with, by offset(). Each brick once, from any thread. `frozen`: voxels that keep their
  /// values. `rows`: those (bits x·8 + y) that what is known may change; the others are solved unless something beside
  /// them changes.
  void begin(size_t i, const float* around, const uint64_t (&frozen)[kBrickEdge], uint64_t rows = ~uint64_t{0}) {
    Solved& b = bricks_[i];
    std::copy_n(frozen, kBrickEdge, b.frozen);
    for (int x = 0; x < kBrickEdge; ++x)
      for (int y = 0; y < kBrickEdge; ++y)
        std::memcpy(b.u[0] + Brick::offset(x, y, 0), around + offset(x + layers, y + layers, layers), kRowBytes);
    b.open = 0;
    for (int row = 0; row < kBrickEdge * kBrickEdge; ++row)
      b.open |= uint64_t{((frozen[row >> 3] >> (8 * (row & 7))) & 0xff) != 0xff} << row;
    b.rows = b.open & rows;
    std::memcpy(b.u[1], b.u[0], sizeof b.u[0]);  // rows that rest
    for (size_t face = 0; face < 6; ++face)
      if (beside_[i][face] < 0) takeRim(around, face, rims_[static_cast<size_t>(-1 - beside_[i][face])]);
  }

  /// `pass(around, frozen, rows, out)` writes the next values of those rows of a brick whose bits (x·8 + y) are set,
  /// and returns those that differ. At most `passes` times, fewer once nothing changes.
  template <class Pass>
  void run(int passes, const Pass& pass) {
    for (int count = 0; count < passes && runOnce(pass); ++count) {
    }
  }
  /// One of the passes of run(); false where nothing changed.
  template <class Pass>
  bool runOnce(const Pass& pass) {
    forEachBrickOf(bricks_.size(), threads_, [&](size_t i) {
      Solved& b = bricks_[i];
      b.changed = 0;
      if (b.rows == 0) return;  // Both of its buffers hold the same.
      float surroundings[kAroundSize];
      gather(i, b.rows, surroundings);
      b.changed = pass(surroundings, b.frozen, b.rows, b.u[now_ ^ 1]);
    });
    if (std::none_of(bricks_.begin(), bricks_.end(), [](const Solved& b) { return b.changed != 0; })) return false;
    now_ ^= 1;
    for (size_t i = 0; i < bricks_.size(); ++i) bricks_[i].rows = bricks_[i].open & rowsThatFollow(i);
    return true;
  }

  /// The 512 values of brick `i` as they are now, and with their layers by offset() (nothing else of `out` is written).
  [[nodiscard]] const float* values(size_t i) const { return bricks_[i].u[now_]; }
  void around(size_t i, float* out) const { gather(i, ~uint64_t{0}, out); }

  /// Writes 512 values where the brick itself stands by offset(), or, of those of the neighbour across a face, the
  /// layers next to it.
  static void putBrick(const float* values, float* out) {
    for (int x = 0; x < kBrickEdge; ++x)
      for (int y = 0; y < kBrickEdge; ++y)
        std::memcpy(out + offset(x + layers, y + layers, layers), values + Brick::offset(x, y, 0), kRowBytes);
  }
  static void putFace(const float* values, size_t face, float* out) {
    const size_t axis = face / 2;
    const int to = firstAround(face), from = firstWithin(face);
    if (axis == 2) {
      for (int i = 0; i < kBrickEdge; ++i)
        for (int j = 0; j < kBrickEdge; ++j)
          std::memcpy(out + placeAround(2, to, i, j), values + placeWithin(2, from, i, j), layers * sizeof(float));
      return;
    }
    for (int layer = 0; layer < layers; ++layer)
      for (int i = 0; i < kBrickEdge; ++i)
        std::memcpy(out + placeAround(axis, to + layer, i, 0), values + placeWithin(axis, from + layer, i, 0),
                    kRowBytes);
  }

 private:
  struct Solved {
    float u[2][kBrickVoxels];  // this pass and the next
    uint64_t frozen[kBrickEdge];
    // Rows with a voxel that is not frozen; those of the next pass; those that the last one changed.
    uint64_t open, rows, changed;
  };
  using Rim = std::array<float, size_t{layers} * kBrickEdge * kBrickEdge>;
  static constexpr size_t kRowBytes = kBrickEdge * sizeof(float);
  static constexpr uint64_t kFirstY = 0x0101010101010101;  // rows with y = 0

  // What rows of brick `i` are computed from: neighbours that are not looked at need not come into the cache.
  void gather(size_t i, uint64_t rows, float* out) const {
    constexpr uint64_t kNearY = (kFirstY << layers) - kFirstY, kNearX = (uint64_t{1} << (8 * layers)) - 1;
    constexpr uint64_t kSeenFrom[6] = {
        kNearX, kNearX << (64 - 8 * layers), kNearY, kNearY << (8 - layers), ~uint64_t{0}, ~uint64_t{0}};
    putBrick(values(i), out);
    for (size_t face = 0; face < 6; ++face) {
      if ((rows & kSeenFrom[face]) == 0) continue;
      const ptrdiff_t other = beside_[i][face];
      if (other < 0)
        putRim(rims_[static_cast<size_t>(-1 - other)], face, out);
      else if (face < 4)
        putFace(values(static_cast<size_t>(other)), face, out);
      else
        putRows(values(static_cast<size_t>(other)), face, rows, out);
    }
  }
  // putFace() along z, of some rows alone.
  static void putRows(const float* values, size_t face, uint64_t rows, float* out) {
    const int to = firstAround(face), from = firstWithin(face);
    for (; rows != 0; rows &= rows - 1) {
      const int row = std::countr_zero(rows);
      std::memcpy(out + placeAround(2, to, row >> 3, row & 7), values + placeWithin(2, from, row >> 3, row & 7),
                  layers * sizeof(float));
    }
  }

  // Voxel (i, j) of a layer across a face: indices along the other two axes, in order.
  static constexpr int placeAround(size_t axis, int layer, int i, int j) {
    return axis == 0   ? offset(layer, i + layers, j + layers)
           : axis == 1 ? offset(i + layers, layer, j + layers)
                       : offset(i + layers, j + layers, layer);
  }
  static constexpr int placeWithin(size_t axis, int layer, int i, int j) {
    return axis == 0 ? Brick::offset(layer, i, j) : axis == 1 ? Brick::offset(i, layer, j) : Brick::offset(i, j, layer);
  }
  // First layer of a face, around the brick and in the neighbour across it.
  static constexpr int firstAround(size_t face) { return face % 2 == 0 ? 0 : kBrickEdge + layers; }
  static constexpr int firstWithin(size_t face) { return face % 2 == 0 ? kBrickEdge - layers : 0; }

  // Rows of brick `i` that are computed from something that the last pass changed, its own rows included, since it
  // wrote them to one buffer alone.
  [[nodiscard]] uint64_t rowsThatFollow(size_t i) const {
    const uint64_t own = bricks_[i].changed;
    uint64_t rows = own;
    for (int step = 1; step <= layers; ++step) {
      const uint64_t low = (kFirstY << (8 - step)) - kFirstY;  // rows with y < 8 − step
      rows |= own << (8 * step) | own >> (8 * step) | (own & low) << step | (own >> step & low);
    }
    const auto beside = [&](size_t face) {
      const ptrdiff_t other = beside_[i][face];
      return other >= 0 ? bricks_[static_cast<size_t>(other)].changed : 0;
    };
    const uint64_t belowX = beside(0), aboveX = beside(1), belowY = beside(2), aboveY = beside(3);
    for (int step = 1; step <= layers; ++step) {
      const uint64_t last = (kFirstY << step) - kFirstY;  // rows with y < step
      rows |= belowX >> (64 - 8 * step) | aboveX << (64 - 8 * step);
      rows |= (belowY >> (8 - step) & last) | (aboveY & last) << (8 - step);
    }
    return rows | beside(4) | beside(5);
  }

  template <class Visit>
  static void forRim(size_t face, const Visit& visit) {
    for (int layer = 0, at = 0; layer < layers; ++layer)
      for (int i = 0; i < kBrickEdge; ++i)
        for (int j = 0; j < kBrickEdge; ++j, ++at)
          visit(static_cast<size_t>(at), placeAround(face / 2, firstAround(face) + layer, i, j));
  }
  static void takeRim(const float* around, size_t face, Rim& rim) {
    forRim(face, [&](size_t at, int place) { rim[at] = around[place]; });
  }
  static void putRim(const Rim& rim, size_t face, float* out) {
    forRim(face, [&](size_t at, int place) { out[place] = rim[at]; });
  }

  std::optional<Scratch::Hold> hold_;
  std::pair<std::unique_ptr<Solved[]>, std::unique_ptr<Rim[]>> own_;
  std::vector<std::array<ptrdiff_t, 6>> beside_;  // index of the neighbour across each face; −1 − that of a rim
  int threads_;
  std::span<Solved> bricks_;
  std::span<Rim> rims_;
  int now_ = 0;
};

}  // namespace argil::clay
