#include "clay/field/wide_distance.h"

#include <algorithm>
#include <cmath>

#include "clay/field/jacobi_solver.h"
#include "clay/field/redistance.h"

namespace argil::clay {

namespace {

using Solver = JacobiSolver<2>;

// Bricks that are made, or looked at.
constexpr size_t kBetweenPauses = 512;
// Bricks whose feet are kept, 6 KB each: those that a tip of a dozen voxels asks for again and again.
constexpr size_t kMostFeet = 512;
// Voxels within this of what was asked for have a neighbour that is not known, so their foot is only a guess.
constexpr float kMargin = 1;

// Distances as a brick or tile of the version has them, on one side; beyond the band not known. Nor so near to its end
// that redistancing leaves what stood there: an old value with no surface near it would be the source of a bulge.
void readSlot(Slot slot, float band, float side, float* u) {
  const float known = band - kRedistanceTolerance;
  if (slot.isTile()) {
    const float value = side * slot.phi(0, band);
    std::fill_n(u, kBrickVoxels, value >= known ? kUnknownDistance : value);
    return;
  }
  BrickValues scratch;
  const BrickValues& phi = slot.brick()->values(scratch);
  for (int i = 0; i < kBrickVoxels; ++i) {
    const float value = side * phi[i];
    u[i] = value >= known ? kUnknownDistance : value;
  }
}

bool isOpen(const WideDistance::Block& block) {
  return std::any_of(std::begin(block.u), std::end(block.u), [](float u) { return u >= kUnknownDistance; });
}

void isSolved(WideDistance::Block& block, float reach) {
  block.solvedTo = std::max(block.solvedTo, reach);
  for (int v = 0; v < kBrickVoxels; ++v) block.known[v >> 6] |= uint64_t{block.u[v] < reach - kMargin} << (v & 63);
}

}  // namespace

const WideDistance::Block* WideDistance::find(Coord brick) const {
  const auto it = blocks_.find(brick);
  return it == blocks_.end() ? nullptr : it->second.get();
}

std::vector<Coord> WideDistance::keepOnly(std::span<const Coord> bricks) {
  std::vector<Coord> forgotten;
  std::erase_if(blocks_, [&](const auto& entry) {
    if (std::binary_search(bricks.begin(), bricks.end(), entry.first)) return false;
    keptFeet_ -= entry.second->feet != nullptr;
    forgotten.push_back(entry.first);
    return true;
  });
  return forgotten;
}

const float* WideDistance::beside(Coord brick, size_t face, float (&room)[kBrickVoxels]) const {
  const Coord near = brick + kFaceSteps[face];
  if (const Block* block = find(near)) return block->u;
  readSlot(version_.find(near), version_.grid().band, side_, room);
  return room;
}

const WideDistance::Feet& WideDistance::feet(Coord brick, Feet& room) const {
  Block& block = *blocks_.at(brick);
  if (block.feetKnown) return *block.feet;
  Feet& feet = block.feet ? *block.feet : room;
  uint64_t rows = 0;
  for (int row = 0; row < kBrickEdge * kBrickEdge; ++row)
    rows |= uint64_t{((block.known[row >> 3] >> (8 * (row & 7))) & 0xff) != 0} << row;
  float wide[kWideSize], read[kBrickVoxels];
  Solver::putBrick(block.u, wide);
  for (size_t face = 0; face < 6; ++face) Solver::putFace(beside(brick, face, read), face, wide);
  if (rows != ~uint64_t{0}) std::fill(std::begin(feet.foot), std::end(feet.foot), 0.0f);
  wideFeet(wide, rows, feet.foot, feet.box);
  block.feetKnown = block.feet != nullptr;
  return feet;
}

void WideDistance::keepFeetOf(std::span<const Coord> bricks) {
  const bool few = bricks.size() <= kMostFeet;
  if (keptFeet_ + (few ? bricks.size() : 0) > kMostFeet) {
    keptFeet_ = 0;
    for (auto& [coord, block] : blocks_) {
      if (!few || !std::binary_search(bricks.begin(), bricks.end(), coord)) {
        block->feet.reset();
        block->feetKnown = false;
      }
      keptFeet_ += block->feet != nullptr;
    }
  }
  if (!few) return;
  for (const Coord coord : bricks) {
    const auto at = blocks_.find(coord);
    if (at == blocks_.end() || at->second->feet) continue;
    at->second->feet = std::make_unique_for_overwrite<Feet>();
    ++keptFeet_;
  }
}

Steps WideDistance::extend(std::span<const Coord> bricks, float reach) {
  const float band = version_.grid().band;
  BrickSet wanted;
  std::vector<Block*> known;  // all of their voxels
  bool any = false;
  for (size_t made = 0; const Coord c : bricks) {
    const auto at = blocks_.find(c);
    Block* block = at == blocks_.end() ? nullptr : at->second.get();
    if (block && block->solvedTo >= reach) continue;
    const float before = block ? block->solvedTo : 0;
    if (!block) {
      const Slot slot = version_.find(c);
      // All of it lies beyond the surface, where nobody asks.
      if (slot.isTile() && side_ * slot.phi(0, band) < 0) continue;
      auto fresh = std::make_unique<Block>();
      readSlot(slot, band, side_, fresh->u);
      for (int i = 0; i < kBrickVoxels; ++i) fresh->frozen[i >> 6] |= uint64_t{fresh->u[i] < band} << (i & 63);
      fresh->open = isOpen(*fresh);
      block = blocks_.emplace(c, std::move(fresh)).first->second.get();
      if (++made % kBetweenPauses == 0) co_yield Steps::kPause;
    }
    if (!block->open) {
      known.push_back(block);
      continue;
    }
    any = true;
    wanted.add(c);
    // What goes on from it, or was solved farther while nothing was known here.
    for (const Coord step : kFaceSteps)
      if (const Block* near = find(c + step); near && (near->open || near->solvedTo > before)) wanted.add(c + step);
  }
  for (Block* each : known) isSolved(*each, reach);
  if (!any) co_return;
  std::vector<Coord> all = wanted.sorted();
  std::sort(all.begin(), all.end());
  std::vector<Block*> blocks(all.size());
  for (size_t i = 0; i < all.size(); ++i) blocks[i] = blocks_.at(all[i]).get();
  const bool inSteps = all.size() > kBetweenPauses;
  Solver solver(all, threads_, inSteps ? Solver::Memory::own : Solver::Memory::ofThread);
  const auto begin = [&](size_t i) {
    float wide[kWideSize], read[kBrickVoxels];
    Solver::putBrick(blocks[i]->u, wide);
    // Around what is solved: from blocks where there are any, else from the version.
    for (size_t face = 0; face < 6; ++face)
      if (!solver.hasBeside(i, face)) Solver::putFace(beside(all[i], face, read), face, wide);
    uint64_t unknown = 0;
    for (int row = 0; row < kBrickEdge * kBrickEdge; ++row) {
      const float* values = blocks[i]->u + row * kBrickEdge;
      unknown |= uint64_t{std::any_of(values, values + kBrickEdge, [](float u) { return u >= kUnknownDistance; })}
                 << row;
    }
    solver.begin(i, wide, blocks[i]->frozen, unknown);
  };
  for (size_t from = 0; from < all.size(); from += kBetweenPauses) {
    forEachBrickOf(std::min(kBetweenPauses, all.size() - from), threads_, [&](size_t i) { begin(from + i); });
    if (inSteps) co_yield Steps::kPause;
  }
  // What is known travels a voxel along an axis a pass and is settled once all upwind of it is.
  const int passes = static_cast<int>(std::ceil(2 * (reach - band))) + 6;
  const auto pass = [&](const float* around, const uint64_t* frozen, uint64_t rows, float* out) {
    return widePass(around, frozen, rows, reach, out);
  };
  for (int count = 0; count < passes && solver.runOnce(pass); ++count)
    if (inSteps) co_yield Steps::kPause;
  const auto end = [&](size_t i) {
    Block& block = *blocks[i];
    std::copy_n(solver.values(i), kBrickVoxels, block.u);
    block.open = isOpen(block);
    isSolved(block, reach);
  };
  for (size_t from = 0; from < all.size(); from += kBetweenPauses) {
    if (inSteps) co_yield Steps::kPause;
    forEachBrickOf(std::min(kBetweenPauses, all.size() - from), threads_, [&](size_t i) { end(from + i); });
  }
  // What is beside a brick that was solved sees it with its slopes.
  if (keptFeet_ == 0) co_return;
  for (size_t i = 0; i < all.size(); ++i) {
    blocks[i]->feetKnown = false;
    for (const Coord step : kFaceSteps)
      if (const auto near = blocks_.find(all[i] + step); near != blocks_.end()) near->second->feetKnown = false;
  }
}

}  // namespace argil::clay
