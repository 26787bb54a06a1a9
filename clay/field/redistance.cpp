#include "clay/field/redistance.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <memory>

#include "clay/field/renewal.h"
#include "clay/store/brick_margins.h"

namespace argil::clay {

namespace {

constexpr int kLeastPasses = 6;
constexpr float kDiagonal = 1.7320508f;

struct Block {
  float u[2][kPaddedSize];  // |phi|: this pass and the next
  uint64_t frozen[8];
  ptrdiff_t beside[6];  // index of the neighbour across each face; −1: not among them
  Slot source;
  ChannelSlot mask;
};

// Copies a face layer of one brick's values into its neighbour's padding; `to` is the neighbour along +axis when
// `positive`.
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

int passesOf(float band) {
  return std::max(kLeastPasses, static_cast<int>(std::ceil(kDiagonal * band)));
}

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

std::vector<Coord> linkSettled(Editor& editor, std::span<const SettledBrick> settled) {
  std::vector<Coord> changed;
  for (const SettledBrick& each : settled) {
    changed.push_back(each.brick->coord);
    editor.link(each.brick, each.inBand);
  }
  return changed;
}

namespace {

std::vector<SettledBrick> solve(Editor& editor, std::span<const Coord> coords, std::span<const Renew> renew,
                                std::span<const uint8_t> wanted, int threads, float tolerance) {
  const bool masks = editor.has(Channel::mask);
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
  for (size_t i = 0; i < count; ++i) {
    Block& b = blocks[i];
    b.source = editor.find(coords[i]);
    for (int face = 0; face < 6; ++face) {
      const auto it = std::lower_bound(coords.begin(), coords.end(), coords[i] + kFaceSteps[face]);
      b.beside[face] = it != coords.end() && *it == coords[i] + kFaceSteps[face] ? it - coords.begin() : -1;
    }
    b.mask = masks ? editor.find(Channel::mask, coords[i]) : ChannelSlot();
  }
  const auto start = [&](size_t i, Sampler& field) {
    Block& b = blocks[i];
    float padded[kPaddedSize];
    std::fill(std::begin(padded), std::end(padded), band);
    gatherPadded(field, coords[i], padded);
    startDistance(padded, band, b.frozen, b.u[0]);
    const Renew how = renew.empty() ? Renew::none : renew[i];
    if (how != Renew::none) renewNearDistance(padded, b.frozen, how == Renew::impossible ? 1 : 0, b.u[0]);
    holdMasked(b.mask, padded, b.frozen, b.u[0]);
    std::memcpy(b.u[1], b.u[0], sizeof b.u[0]);
  };
  forBrickRanges(count, threads, [&](size_t begin, size_t end) {
    Sampler field(editor);
    for (size_t i = begin; i < end; ++i) start(i, field);
  });
  int now = 0;
  for (int pass = 0, passes = passesOf(band); pass < passes; ++pass, now ^= 1)
    forEachBrickOf(count, threads, [&](size_t i) {
      Block& b = blocks[i];
      // Between blocks the padding follows the neighbour; elsewhere it stays what the field says.
      for (int face = 0; face < 6; ++face)
        if (b.beside[face] >= 0)
          copyFace(blocks[static_cast<size_t>(b.beside[face])].u[now], b.u[now], face / 2, face % 2 == 0);
      eikonalPass(b.u[now], b.frozen, band, b.u[now ^ 1]);
    });
  const float allowed[] = {tolerance, kSlopeTolerance, kSlopeTolerance};
  return settleBricks(editor, coords, wanted, threads, [&](size_t i, FloatBrick& brick) {
    BrickValues room;
    const float most = allowed[renew.empty() ? 0 : static_cast<size_t>(renew[i])];
    return settleDistance(blocks[i].source.values(room, band), blocks[i].u[now], band, most, brick);
  });
}

}  // namespace

std::vector<SettledBrick> solveDistances(Editor& editor, std::span<const Coord> coords, std::span<const uint8_t> wanted,
                                         int threads) {
  return solve(editor, coords, {}, wanted, threads, kRedistanceTolerance);
}

std::vector<Coord> redistance(Editor& editor, std::span<const Coord> coords, std::span<const Renew> renew, int threads,
                              float tolerance) {
  if (std::any_of(renew.begin(), renew.end(), [](Renew how) { return how == Renew::all; }))
    return renewDistances(editor, coords, renew, threads);
  return linkSettled(editor, solve(editor, coords, renew, {}, threads, tolerance));
}

}  // namespace argil::clay
