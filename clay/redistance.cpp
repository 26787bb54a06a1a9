#include "clay/redistance.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "clay/renewal.h"

namespace argil::clay {

namespace {

constexpr int kLeastPasses = 6;
constexpr float kDiagonal = 1.7320508f;

struct Block {
  float u[2][kPaddedSize];  // |phi|: this pass and the next
  uint64_t frozen[8];
  Slot source;
};

// Copies a face layer of one brick's values into its neighbour's padding; `to` is the neighbour along +axis when `positive`.
void copyFace(const float* from, float* to, int axis, bool positive) {
  const int source = positive ? 8 : 1, target = positive ? 0 : 9;
  for (int i = 1; i <= 8; ++i) {
    if (axis == 0)
      std::memcpy(to + paddedOffset(target, i, 1), from + paddedOffset(source, i, 1), kBrickEdge * sizeof(float));
    else if (axis == 1)
      std::memcpy(to + paddedOffset(i, target, 1), from + paddedOffset(i, source, 1), kBrickEdge * sizeof(float));
    else
      for (int j = 1; j <= 8; ++j) to[paddedOffset(i, j, target)] = from[paddedOffset(i, j, source)];
  }
}

}  // namespace

int passesOf(float band) { return std::max(kLeastPasses, static_cast<int>(std::ceil(kDiagonal * band))); }

void gatherPadded(Sampler& field, Coord coord, float* padded) noexcept {
  const float band = field.band();
  const auto range = [](int side, int& begin, int& end) {
    begin = side < 0 ? 0 : side == 0 ? 1 : 9;
    end = side < 0 ? 1 : side == 0 ? 9 : 10;
  };
  for (int sx = -1; sx <= 1; ++sx)
    for (int sy = -1; sy <= 1; ++sy)
      for (int sz = -1; sz <= 1; ++sz) {
        const Slot slot = field.slot(coord + Coord{sx, sy, sz});
        int x0, x1, y0, y1, z0, z1;
        range(sx, x0, x1);
        range(sy, y0, y1);
        range(sz, z0, z1);
        const Brick* brick = slot.brick();
        const float constant = brick ? 0 : slot.phi(0, band);
        for (int x = x0; x < x1; ++x)
          for (int y = y0; y < y1; ++y) {
            float* row = padded + paddedOffset(x, y, z0);
            if (!brick) {
              std::fill(row, row + (z1 - z0), constant);
            } else {
              brick->read(Brick::offset((x + 7) & 7, (y + 7) & 7, (z0 + 7) & 7), z1 - z0, row, field.step());
            }
          }
      }
}

void holdMasked(ChannelSlot mask, const float* padded, uint64_t (&frozen)[kBrickEdge], float* u) {
  if (mask == ChannelSlot()) return;
  for (int v = 0; v < kBrickVoxels; ++v) {
    if (mask.value(v) != 255) continue;
    const int at = paddedOffset((v >> 6) + 1, ((v >> 3) & 7) + 1, (v & 7) + 1);
    frozen[v >> 6] |= uint64_t{1} << (v & 63);
    u[at] = std::abs(padded[at]);
  }
}

bool settleBrick(Editor& editor, Coord coord, Slot was, const float* solved, float tolerance) {
  const float band = editor.grid().band;
  BrickValues room;
  FloatBrick* brick = editor.newBrick(coord);
  const BrickChange change = settleDistance(was.values(room, band), solved, band, tolerance, *brick);
  if (change.changed)
    editor.link(brick, change.inBand);
  else
    editor.recycle(brick);
  return change.changed;
}

std::vector<Coord> redistance(Editor& editor, std::span<const Coord> coords, std::span<const Renew> renew) {
  if (std::any_of(renew.begin(), renew.end(), [](Renew how) { return how == Renew::all; })) return renewDistances(editor, coords, renew);
  const bool masks = editor.has(Channel::mask);
  Sampler field(editor);
  const float band = editor.grid().band;
  const auto count = coords.size();
  // Kept between calls: a megabyte of fresh pages would cost more than the passes.
  static thread_local std::unique_ptr<Block[]> scratch;
  static thread_local size_t capacity = 0;
  if (capacity < count) {
    capacity = std::max(count, 2 * capacity);
    scratch = std::make_unique_for_overwrite<Block[]>(capacity);
  }
  const std::span<Block> blocks(scratch.get(), count);
  const auto indexOf = [&](Coord c) -> ptrdiff_t {
    const auto it = std::lower_bound(coords.begin(), coords.end(), c);
    return it != coords.end() && *it == c ? it - coords.begin() : -1;
  };

  for (size_t i = 0; i < count; ++i) {
    Block& b = blocks[i];
    b.source = editor.find(coords[i]);
    float padded[kPaddedSize];
    std::fill(std::begin(padded), std::end(padded), band);
    gatherPadded(field, coords[i], padded);
    startDistance(padded, band, b.frozen, b.u[0]);
    const Renew how = renew.empty() ? Renew::none : renew[i];
    if (how != Renew::none) renewNearDistance(padded, b.frozen, how == Renew::impossible ? 1 : 0, b.u[0]);
    if (masks) holdMasked(editor.find(Channel::mask, coords[i]), padded, b.frozen, b.u[0]);
    std::memcpy(b.u[1], b.u[0], sizeof b.u[0]);
  }
  // Between blocks the padding follows the neighbour; elsewhere it stays what the field says.
  struct Face {
    size_t from, to;
    int axis;
    bool positive;
  };
  std::vector<Face> faces;
  for (size_t i = 0; i < count; ++i)
    for (int axis = 0; axis < 3; ++axis) {
      const Coord step{axis == 0, axis == 1, axis == 2};
      const ptrdiff_t up = indexOf(coords[i] + step);
      if (up < 0) continue;
      faces.push_back({i, static_cast<size_t>(up), axis, true});
      faces.push_back({static_cast<size_t>(up), i, axis, false});
    }
  constexpr float kTolerance[] = {kRedistanceTolerance, kSlopeTolerance, kSlopeTolerance};
  int now = 0;
  for (int pass = 0, passes = passesOf(band); pass < passes; ++pass, now ^= 1) {
    for (const Face& f : faces) copyFace(blocks[f.from].u[now], blocks[f.to].u[now], f.axis, f.positive);
    for (Block& b : blocks) {
      eikonalPass(b.u[now], b.frozen, band, b.u[now ^ 1]);
    }
  }

  std::vector<Coord> changed;
  for (size_t i = 0; i < count; ++i)
    if (settleBrick(editor, coords[i], blocks[i].source, blocks[i].u[now], kTolerance[renew.empty() ? 0 : static_cast<size_t>(renew[i])])) changed.push_back(coords[i]);
  return changed;
}

}  // namespace argil::clay
