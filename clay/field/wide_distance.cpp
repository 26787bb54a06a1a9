#include "clay/field/wide_distance.h"

#include <algorithm>
#include <cmath>
#include <cstring>

#include "clay/base/parallel.h"
#include "clay/field/scratch.h"
#include "clay/store/brick_margins.h"

namespace argil::clay {

namespace {

// Voxels within this of what was asked for have a neighbour that is not known, so their foot is only a guess.
constexpr float kMargin = 1;
// Bricks that are worth a second thread.
constexpr size_t kParallelFrom = 128;

// Distances as a brick or tile of the version has them, on one side; beyond the band not known.
void readSlot(Slot slot, float band, float side, float* u) {
  if (slot.isTile()) {
    const float value = side * slot.phi(0, band);
    std::fill_n(u, kBrickVoxels, value >= band ? kUnknownDistance : value);
    return;
  }
  BrickValues scratch;
  const BrickValues& phi = slot.brick()->values(scratch);
  for (int i = 0; i < kBrickVoxels; ++i) {
    const float value = side * phi[i];
    u[i] = value >= band ? kUnknownDistance : value;
  }
}

void spread(const float* u, float* wide) {
  for (int x = 0; x < 8; ++x)
    for (int y = 0; y < 8; ++y)
      std::memcpy(wide + wideOffset(x + 2, y + 2, 2), u + Brick::offset(x, y, 0), kBrickEdge * sizeof(float));
}

}  // namespace

struct WideDistance::Work {
  Coord coord;
  Block* block = nullptr;
  float u[2][kWideSize];
  std::array<ptrdiff_t, 6> beside;  // index of the neighbour across each face, −1: not among them
  bool open, active, changed;       // has voxels beyond the band; its next pass may change it; the last one did
};

const WideDistance::Block* WideDistance::find(Coord brick) const {
  const auto it = blocks_.find(brick);
  return it == blocks_.end() ? nullptr : it->second.get();
}

void WideDistance::keepOnly(std::span<const Coord> bricks) {
  std::erase_if(blocks_,
                [&](const auto& entry) { return !std::binary_search(bricks.begin(), bricks.end(), entry.first); });
}

// The values of a brick and two layers across its faces, from blocks where there are any, else from the version.
void WideDistance::gather(Work& work) const {
  const float band = version_.grid().band;
  float* wide = work.u[0];
  std::fill(wide, wide + kWideSize, kUnknownDistance);
  const auto values = [&](Coord coord, float(&read)[kBrickVoxels]) -> const float* {
    if (const Block* block = find(coord)) return block->u;
    readSlot(version_.find(coord), band, side_, read);
    return read;
  };
  spread(work.block->u, wide);
  for (size_t face = 0; face < 6; ++face) {
    if (work.beside[face] >= 0) continue;
    float other[kWideSize], read[kBrickVoxels];
    spread(values(work.coord + kFaceSteps[face], read), other);
    copyLayers(other, wide, int(face) / 2, face % 2 == 0);
  }
}

void WideDistance::extend(std::span<const Coord> bricks, float reach) {
  const float band = version_.grid().band;
  BrickSet wanted;
  std::vector<Coord> fresh;
  bool any = false;
  for (const Coord c : bricks) {
    const Block* block = find(c);
    if (block && block->solvedTo >= reach) continue;
    if (!block) {
      const Slot slot = version_.find(c);
      // All of it lies beyond the surface, where nobody asks.
      if (slot.isTile() && side_ * slot.phi(0, band) < 0) continue;
      auto made = std::make_unique<Block>();
      readSlot(slot, band, side_, made->u);
      for (int i = 0; i < kBrickVoxels; ++i) made->frozen[i >> 6] |= uint64_t{made->u[i] < band} << (i & 63);
      blocks_.emplace(c, std::move(made));
    }
    any = true;
    wanted.add(c);
    // What is beside it was solved without it.
    for (const Coord step : kFaceSteps)
      if (find(c + step)) wanted.add(c + step);
  }
  if (!any) return;
  std::vector<Coord> all = wanted.sorted();
  std::sort(all.begin(), all.end());
  const std::span<Work> works = Scratch::of<Work>(all.size());
  const auto beside = besideEach(std::span<const Coord>(all), kFaceSteps);
  for (size_t i = 0; i < all.size(); ++i) {
    Work& w = works[i];
    w.coord = all[i];
    w.block = blocks_.at(all[i]).get();
    w.changed = false;
    w.beside = beside[i];
    w.open = false;
    for (const uint64_t word : w.block->frozen) w.open |= ~word != 0;
    w.active = w.open;
  }
  // Each brick writes its own values and margins alone, and reads of others what nobody writes meanwhile.
  const auto forEach = [&](const auto& visit) {
    parallelBlocks(
        works.size(), works.size() >= kParallelFrom ? threads_ : 1,
        [&](size_t begin, size_t end) {
          for (size_t i = begin; i < end; ++i) visit(works[i]);
        },
        32);
  };
  const auto pull = [&](Work& w, int which) {
    for (size_t face = 0; face < 6; ++face)
      if (w.beside[face] >= 0)
        copyLayers(works[static_cast<size_t>(w.beside[face])].u[which], w.u[which], int(face) / 2, face % 2 == 0);
  };
  forEach([&](Work& w) {
    gather(w);
    std::copy_n(w.u[0], kWideSize, w.u[1]);
  });
  // What is known travels a voxel along an axis a pass and is settled once all upwind of it is: bricks rest while they
  // and their neighbours do.
  const int passes = static_cast<int>(std::ceil(2 * (reach - band))) + 6;
  int now = 0;
  for (int pass = 0; pass < passes; ++pass, now ^= 1) {
    forEach([&](Work& w) {
      if (w.active) pull(w, now);
      w.changed = w.active && widePass(w.u[now], w.block->frozen, reach, w.u[now ^ 1]);
    });
    if (std::none_of(works.begin(), works.end(), [](const Work& w) { return w.changed; })) break;
    // One that rests has the same values in both.
    for (Work& w : works) {
      w.active = w.changed;
      for (const ptrdiff_t other : w.beside) w.active |= other >= 0 && works[static_cast<size_t>(other)].changed;
      w.active = w.active && w.open;
    }
  }
  forEach([&](Work& w) {
    pull(w, now);
    Block& block = *w.block;
    block.solvedTo = std::max(block.solvedTo, reach);
    const float* u = w.u[now];
    for (int x = 0; x < 8; ++x)
      for (int y = 0; y < 8; ++y) std::copy_n(u + wideOffset(x + 2, y + 2, 2), 8, block.u + Brick::offset(x, y, 0));
    uint64_t some = 0;
    for (int i = 0; i < kBrickVoxels; ++i)
      some |= block.known[i >> 6] |= uint64_t{block.u[i] < reach - kMargin} << (i & 63);
    if (some == 0) return;
    if (!block.foot) block.foot = std::make_unique_for_overwrite<float[]>(3 * kBrickVoxels);
    wideFeet(u, block.foot.get(), block.feet);
  });
}

}  // namespace argil::clay
